// The connection to the panel.
//
// In: messages of the panel. Out: messages to it, each with a number, and their answers. A connection that breaks is made again;
// authority is not taken again by itself.

const KEY = 'mrroc-token';

export class Link {
  /** `hear` gets every message, `tell` what has become of the connection. */
  constructor(hear, tell) {
    this.hear = hear;
    this.tell = tell;
    this.number = 0;
    this.unasked = null;
    this.waiting = new Map();
    // The token is in the fragment of the address, which no browser sends; it is not left there.
    const given = new URLSearchParams(location.hash.slice(1)).get('token');
    if (given) {
      sessionStorage.setItem(KEY, given);
      history.replaceState(null, '', location.pathname);
    }
    this.token = sessionStorage.getItem(KEY);
  }

  /** Connects with a token, now and whenever the connection breaks. */
  open(token = this.token) {
    this.token = token;
    if (!token) {
      this.tell('token', '');
      return;
    }
    const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/connect`);
    this.socket = socket;
    let known = false;
    socket.onopen = () => socket.send(JSON.stringify({ token }));
    socket.onmessage = (event) => {
      const message = JSON.parse(event.data);
      if (!known) {
        known = true;
        sessionStorage.setItem(KEY, token);
        this.tell('open', '');
      }
      if (message.kind === 'answer') {
        const answered = this.waiting.get(message.n);
        this.waiting.delete(message.n);
        // What was said without a number is answered only if it was refused.
        (answered ?? this.unasked)?.(message);
      }
      this.hear(message);
    };
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.waiting.forEach((answered) => answered({ outcome: 'refused', text: 'the connection is closed' }));
      this.waiting.clear();
      if (!known && event.code === 1008) {
        sessionStorage.removeItem(KEY);
        this.tell('token', event.reason);
        return;
      }
      this.tell('closed', event.reason);
      setTimeout(() => this.open(), 1000);
    };
  }

  get isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** Says something of which no answer is awaited. */
  say(message) {
    // What a connection does not take at once is old when it gets there.
    if (this.isOpen && this.socket.bufferedAmount < 4096) this.socket.send(JSON.stringify(message));
  }

  /** Asks for something; gives the answer. */
  ask(message) {
    if (!this.isOpen) return Promise.resolve({ outcome: 'refused', text: 'the panel cannot be reached' });
    const n = ++this.number;
    return new Promise((answered) => {
      this.waiting.set(n, answered);
      this.socket.send(JSON.stringify({ n, ...message }));
    });
  }
}
