// Slider, buttons and keys that choose the stance, under the contact schedule.
import { describeChange } from './data.js';
import { el, svg } from './dom.js';
import { schedule } from './schedule.js';

const STEP_MS = 900;

export class Transport {
  /** `show` draws a stance; it is called for every choice. */
  constructor(element, stances, show) {
    this.stances = stances;
    this.count = stances.length;
    this.index = 0;
    this.show = show;
    this.timer = null;
    if (!this.count) {
      element.append(el('p', { class: 'empty' }, 'The plan has no stances.'));
      return;
    }
    this.slider = el('input', {
      type: 'range', id: 'stance', min: 0, max: this.count - 1, step: 1, value: 0, 'aria-label': 'Stance',
      oninput: () => {
        this.pause();
        this.set(Number(this.slider.value));
      },
    });
    this.number = el('output', { class: 'number', for: 'stance' });
    const button = (name, path, action, title) =>
      el('button', { type: 'button', id: name, 'aria-label': title, title, onclick: action },
        svg('svg', { viewBox: '0 0 16 16', class: 'icon' }, svg('path', { d: path })));
    this.playButton = el('button', { type: 'button', id: 'play', title: 'Space', onclick: () => this.toggle() });
    const grid = el('div', { class: 'schedule' },
      schedule(stances, (i) => {
        this.pause();
        this.set(i);
      }),
      el('span', { class: 'lane-name' }, 'stance'),
      el('div', { class: 'rail' }, this.slider));
    grid.style.setProperty('--count', this.count);
    this.grid = grid;
    element.append(
      el('div', { class: 'buttons' },
        button('first', 'M4 4v8M13 4l-6 4l6 4z', () => this.step(-this.count), 'First stance (Home)'),
        button('back', 'M11 4l-6 4l6 4z', () => this.step(-1), 'Stance before (\u2190)'),
        this.playButton,
        button('next', 'M5 4l6 4l-6 4z', () => this.step(1), 'Next stance (\u2192)'),
        button('last', 'M12 4v8M3 4l6 4l-6 4z', () => this.step(this.count), 'Last stance (End)'),
        this.number),
      grid);
    this.drawPlay();
  }

  set(index) {
    this.index = Math.min(Math.max(Math.round(index), 0), this.count - 1);
    this.slider.value = this.index;
    this.slider.setAttribute('aria-valuetext', `stance ${this.index} of ${this.count - 1}: ${describeChange(this.stances[this.index].change)}`);
    this.number.replaceChildren(el('b', {}, String(this.index)), ` / ${this.count - 1}`);
    this.grid.style.setProperty('--index', this.index);
    this.show(this.index);
  }

  step(by) {
    this.pause();
    this.set(this.index + by);
  }

  toggle() {
    if (this.timer) return this.pause();
    if (this.index === this.count - 1) this.set(0);
    this.timer = setInterval(() => {
      this.set(this.index + 1);
      if (this.index === this.count - 1) this.pause();
    }, STEP_MS);
    return this.drawPlay();
  }

  pause() {
    clearInterval(this.timer);
    this.timer = null;
    this.drawPlay();
  }

  drawPlay() {
    this.playButton.textContent = this.timer ? 'Pause' : 'Play';
    this.playButton.setAttribute('aria-pressed', String(Boolean(this.timer)));
  }
}
