// SPDX-License-Identifier: MIT
// <feeling-wind src="film.mp4" track="film.klv">: a film that is felt, in any page. The hand is the mouse, a finger, or
// the arrow keys. docs/web.md, "Put it into a page".
import { draw, pictureIn } from './drawing.js';
import { Hold, watchHolding } from './hold.js';
import { attach } from './player.js';
import { sentenceFor } from './problems.js';

export { Hold, watchHolding } from './hold.js';
export { Problem, Refusal, attach, useHls } from './player.js';

const STEP = 0.02; // of the picture, a key moves the hand
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const LABEL = 'Film to be felt. The arrow keys move the hand over it, H holds what is under it.';
const STYLE = `
  :host { display: block; position: relative; }
  video, ::slotted(video) { display: block; width: 100%; touch-action: none; }
  div { position: relative; }
  canvas { position: absolute; inset: 0; width: 100%; height: 100%; pointer-events: none; }
  p { margin: .4em 0; }
`;

const make = (name, properties) => Object.assign(document.createElement(name), properties);

export class FeelingWind extends (globalThis.HTMLElement ?? Object) {
  static observedAttributes = ['src', 'track', 'alpha', 'strength'];
  #canvas = null;
  #problems = null;
  #video = null;
  #player = null;
  #listening = null;

  /** What attach() gives; null while the element is in no page. */
  get player() { return this.#player; }
  get video() { return this.#video; }

  connectedCallback() {
    if (!this.shadowRoot) this.#build();
    this.#listening = new AbortController();
    const { signal } = this.#listening;
    this.#player = attach(this.#video, {
      signal, hlsConfig: this.hlsConfig, allowedOrigins: this.allowedOrigins, texts: this.texts,
      onProblem: sentence => this.#say(sentence),
    });
    for (const event of ['force', 'relief', 'problem', 'hold'])
      this.#player.addEventListener(event, ({ detail, code }) => {
        this.dispatchEvent(Object.assign(new Event(event), { detail, code }));
        this.#draw();
      });
    this.#listen(signal);
    const poll = watchHolding(this.#video, new Hold(this.#player, this.#video, signal), this, signal);
    this.#player.addEventListener('force', poll);
    this.attributeChangedCallback('alpha');
    this.attributeChangedCallback('strength');
    this.#load();
  }

  disconnectedCallback() {
    this.#listening.abort();
    this.#player = null;
  }

  attributeChangedCallback(name) {
    if (!this.#player) return;
    if (name === 'src' || name === 'track') this.#load();
    else if (this.hasAttribute(name)) this.#player[name] = Number(this.getAttribute(name));
  }

  #build() {
    const root = this.attachShadow({ mode: 'open' });
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(STYLE);
    root.adoptedStyleSheets = [sheet];
    const own = this.querySelector('video');
    this.#video = own ?? make('video', { controls: true, playsInline: true });
    this.#canvas = make('canvas');
    this.#canvas.setAttribute('aria-hidden', 'true');
    this.#problems = make('p');
    this.#problems.setAttribute('role', 'alert');
    const stage = make('div');
    stage.append(own ? make('slot') : this.#video, this.#canvas);
    root.append(stage, this.#problems);
    if (!this.hasAttribute('tabindex')) this.tabIndex = 0;
    if (!this.hasAttribute('role')) this.setAttribute('role', 'application');
    if (!this.hasAttribute('aria-label')) this.setAttribute('aria-label', LABEL);
  }

  #load() {
    const src = this.getAttribute('src'), track = this.getAttribute('track');
    this.#problems.textContent = '';
    const refuse = refusal => {
      const detail = sentenceFor(refusal, this.texts);
      this.#say(detail);
      this.dispatchEvent(Object.assign(new Event('problem'), { detail, code: refusal.code }));
    };
    if (/\.m3u8([?#]|$)/i.test(src ?? '')) return void this.#player.load(src).catch(refuse);
    if (src !== null && this.#video.getAttribute('src') !== src) this.#video.src = src;
    this.#player.loadTrack(track).catch(refuse);
  }

  #listen(signal) {
    const on = (target, events, listener) => {
      for (const event of events) target.addEventListener(event, listener, { signal });
    };
    on(this.#video, ['pointerdown', 'pointermove'], event => event.isPrimary && this.#point(event));
    on(this.#video, ['pointerdown'], ({ isPrimary, button }) => {
      if (isPrimary && button === 0) this.#player.pressed = true;
    });
    on(this.#video, ['pointerup', 'pointercancel', 'pointerleave'], ({ type, pointerType, isPrimary }) => {
      if (!isPrimary) return;
      this.#player.pressed = false;
      if (type === 'pointerleave' || pointerType !== 'mouse') this.#move(null);
    });
    on(this, ['keydown'], event => {
      const arrow = ARROWS[event.key];
      if (event.target !== this || event.composedPath()[0] !== this) return;
      if (event.key === 'Escape') this.#move(null);
      if (!arrow) return;
      const { x, y } = this.#player.place ?? { x: 0.5, y: 0.5 };
      this.#move({ x: x + STEP * arrow[0], y: y + STEP * arrow[1] });
      event.preventDefault();
    });
  }

  #point({ clientX, clientY }) {
    const box = this.#video.getBoundingClientRect();
    const picture = pictureIn(this.#video, this.#video);
    const x = (clientX - box.left - picture.x) / picture.width, y = (clientY - box.top - picture.y) / picture.height;
    this.#move(x >= 0 && x <= 1 && y >= 0 && y <= 1 ? { x, y } : null);
  }

  #move(place) {
    this.#player.place = place;
    this.#draw();
  }

  #draw() {
    if (this.#player) draw(this.#canvas, this.#video, this.#video, { ...handOf(this.#player), field: null });
  }

  #say(sentence) {
    this.#problems.append(sentence, make('br'));
  }
}

const handOf = ({ place, force, hold }) => ({ place, force, hold });

if (globalThis.customElements && !customElements.get('feeling-wind'))
  customElements.define('feeling-wind', FeelingWind);
