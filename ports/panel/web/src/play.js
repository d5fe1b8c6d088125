// Playing a run that is over.
//
// In: how long it lasts. Out: the times at which the page asks what the cell did; the next one when the last one has come.

const by = (id) => document.getElementById(id);

export class Player {
  constructor(link) {
    this.link = link;
    this.at = 0;
    this.lasts = 0;
    this.plays = false;
    this.waits = false;
    by('play').addEventListener('click', () => this.toggle());
    by('at').addEventListener('input', () => {
      this.at = Number(by('at').value);
      this.anew();
    });
    by('player').addEventListener('submit', (event) => event.preventDefault());
  }

  begin(lasts) {
    this.lasts = lasts;
    this.waits = false;
    by('player').hidden = false;
    by('at').max = lasts;
    by('at').step = Math.max(0.001, lasts / 2000);
    this.anew();
  }

  /** What is plotted is another thing: the minute is asked for anew. */
  anew() {
    this.jumped = true;
    this.ask();
  }

  toggle() {
    this.plays = !this.plays;
    if (this.plays && this.at >= this.lasts) {
      this.at = 0;
      this.jumped = true;
    }
    this.last = performance.now();
    by('play').textContent = this.plays ? 'Pause' : 'Play';
    if (this.plays) requestAnimationFrame((now) => this.advance(now));
  }

  advance(now) {
    if (!this.plays) return;
    // Thirty pictures a second are enough, and leave the panel in peace.
    if (now - this.last > 32) {
      this.at = Math.min(this.lasts, this.at + (Number(by('pace').value) * (now - this.last)) / 1000);
      this.last = now;
      this.ask();
      if (this.at >= this.lasts) this.toggle();
    }
    requestAnimationFrame((next) => this.advance(next));
  }

  ask() {
    by('at').value = this.at;
    by('clock').textContent = `${this.at.toFixed(2)} of ${this.lasts.toFixed(2)} s`;
    by('at').setAttribute('aria-valuetext', `${this.at.toFixed(2)} seconds`);
    if (this.waits) {
      this.again = true;
      return;
    }
    this.waits = true;
    // Where it does not go on from what was shown, the minute before is asked for with it.
    this.leapt = this.jumped;
    this.jumped = false;
    this.link.say({ do: 'frame', at: this.at, minute: this.leapt });
  }

  /** What was asked for has come; whether it goes on from what was shown before. */
  came() {
    this.waits = false;
    const leapt = this.leapt;
    this.leapt = false;
    if (this.again) {
      this.again = false;
      this.ask();
    }
    return !leapt;
  }
}
