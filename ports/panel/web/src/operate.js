// Operating: what a person presses becomes a message, and what the robots do becomes the look of the buttons.
//
// In: states of the cell, answers, presses of the buttons in `index.html`, each with the states in which it does something. Out: messages with the epoch and the step that the page showed. A button shows what the
// cell does, never that it was clicked.

/** How often a page says that it is there, and that somebody holds [ms]. */
const BEAT = 100;
/** How long the cell may take to become what was asked for [ms]. */
const ANSWERED = 1500;

const by = (id) => document.getElementById(id);

export class Operating {
  constructor(link) {
    this.link = link;
    this.state = null;
    this.yours = false;
    /** Whether it is this page that gives control back. */
    this.leaves = false;
    this.held = null;
    by('stop').addEventListener('click', () => this.stop());
    addEventListener('keydown', (event) => {
      if (event.key === 'Escape' && !by('door').open) this.stop();
    });
    by('take').addEventListener('click', () => {
      this.leaves = this.yours;
      this.press(by('take'), { do: this.yours ? 'release' : 'take' }, this.yours ? null : 'you have control');
    });
    for (const button of document.querySelectorAll('[data-do]')) {
      button.addEventListener('click', () => this.press(button, { do: button.dataset.do, ...this.stamp() }));
    }
    by('speed').addEventListener('change', () => {
      this.press(by('speed'), { do: 'speed', rest: `${by('speed').value}%`, ...this.stamp() });
    });
    by('reduced').addEventListener('click', () => {
      this.press(by('reduced'), { do: 'reduced', rest: this.state?.reduced ? 'off' : 'on', ...this.stamp() });
    });
    this.holding(by('hold'));
    link.unasked = (answer) => this.stands(answer);
    addEventListener('blur', () => this.letGo());
    // A button that is gone or disabled while it is held hears nothing of it.
    for (const event of ['pointerup', 'pointercancel', 'keyup']) addEventListener(event, () => this.letGo());
    addEventListener('pagehide', () => this.letGo());
    document.addEventListener('visibilitychange', () => { if (document.hidden) this.letGo(); });
    setInterval(() => this.beat(), BEAT);
  }

  /** Which epoch and step this page shows. */
  stamp() {
    return { epoch: this.state?.epoch ?? 0, step: this.state?.step ?? 0 };
  }

  /** `done` says in place of the answer's words that it was done. */
  async press(button, message, done = null) {
    button.setAttribute('aria-busy', 'true');
    const { outcome, text } = await this.link.ask(message);
    button.removeAttribute('aria-busy');
    this.tell(outcome, outcome === 'done' ? done ?? text : text);
    this.draw();
    return outcome;
  }

  async stop() {
    const { outcome, text } = await this.link.ask({ do: 'stop' });
    this.tell(outcome, text);
  }

  tell(outcome, text) {
    const answer = by('answer');
    this.told = performance.now();
    answer.dataset.outcome = outcome;
    answer.textContent = outcome === 'done' ? text : `${outcome}: ${text}`;
  }

  /** A button that counts only while it is held, by a pointer or a key; `jog` gives what it asks of a robot, if it moves one. */
  holding(button, jog = null) {
    const begin = (event) => {
      if (button.disabled || this.held || event.repeat || (event.button ?? 0) !== 0) return;
      event.preventDefault();
      button.focus();
      const message = jog ? { do: 'jog', ...jog() } : { do: 'hold' };
      this.held = { button, message };
      button.dataset.pressed = 'true';
      if (event.pointerId !== undefined) button.setPointerCapture(event.pointerId);
      this.link.ask({ ...message, begins: true, ...this.stamp() }).then(({ outcome, text }) => {
        if (outcome !== 'done') this.stands({ outcome, text });
      });
    };
    const end = () => { if (this.held?.button === button) this.letGo(); };
    button.addEventListener('pointerdown', begin);
    button.addEventListener('keydown', (event) => {
      if (event.key === ' ' || event.key === 'Enter') begin(event);
    });
    for (const event of ['pointerup', 'pointercancel', 'lostpointercapture', 'keyup', 'blur', 'contextmenu']) button.addEventListener(event, end);
  }

  /** What is held moves nothing: why. */
  stands({ outcome, text }) {
    if (this.held) {
      // It is asked again and again: the first answer stays.
      if (this.held.why) return;
      this.held.why = text;
      this.held.button.dataset.refused = 'true';
    }
    this.tell(outcome, text);
  }

  /** Nothing is held any more. */
  letGo() {
    if (!this.held) return;
    delete this.held.button.dataset.pressed;
    delete this.held.button.dataset.refused;
    this.held = null;
    this.link.say({ do: 'let-go' });
  }

  beat() {
    if (!this.yours || document.hidden) return;
    if (this.held && (this.held.button.disabled || !this.held.button.isConnected)) this.letGo();
    this.link.say({ do: 'beat' });
    if (this.held) this.link.say({ ...this.held.message, ...this.stamp() });
  }

  /** Who has control. */
  authority({ page, yours }) {
    if (this.yours && !yours && !this.leaves) this.tell('refused', 'this page has lost control, since it was silent for 300 ms: take control again');
    this.yours = yours;
    this.leaves = false;
    if (!yours) this.letGo();
    by('authority').textContent = yours ? 'You have control.' : page ? `Page ${page} has control.` : '';
    this.page = page;
    this.draw();
  }

  show(state) {
    // What was answered before the cell came to be as it is now says nothing any more.
    if (this.state && this.state.state !== state.state && performance.now() - this.told > ANSWERED) by('answer').textContent = '';
    this.state = state;
    this.draw();
  }

  draw() {
    const { state, yours } = this;
    const open = this.link.isOpen && state !== null;
    by('take').textContent = yours ? 'Let go of control' : 'Take control';
    by('take').setAttribute('aria-pressed', yours);
    by('take').disabled = !open;
    for (const button of document.querySelectorAll('[data-do]')) {
      button.disabled = !open || !yours || !button.dataset.in.split(' ').includes(state.state);
    }
    document.querySelector('[data-do="suspend"]').setAttribute('aria-pressed', state?.state === 'suspended');
    by('speed').disabled = by('reduced').disabled = !open || !yours;
    if (state && !yours && !this.page) {
      by('authority').textContent = state.holder ? `The console of process ${state.holder} has control.` : 'Nobody has control.';
    }
    if (state) {
      const percent = Math.round(100 * state.speed);
      by('speed-set').textContent = `${percent} %`;
      if (document.activeElement !== by('speed') || !yours) by('speed').value = percent;
      by('reduced').setAttribute('aria-pressed', state.reduced);
      by('hold').disabled = !open || !yours || !state.reduced;
      by('hold').dataset.held = state.held;
      by('hold').textContent = state.held ? 'Held' : 'Hold to run';
      by('reduced-help').hidden = !state.reduced;
    }
  }
}
