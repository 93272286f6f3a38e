// Slider, buttons and keys that choose the stance, under the contact schedule; Play runs through the
// motion, or through the stances where there is none.
import { describeChange } from './data.js';
import { el, svg } from './dom.js';
import { schedule } from './schedule.js';

const STEP_MS = 900;
/** How much faster than the robot the motion is played. */
const SPEEDS = [1, 2, 4, 8];
const SPEED = 4;

export class Transport {
  /**
   * `show` draws a stance; it is called for every choice. `showTime` draws the robot at a time of the
   * motion, which may be null.
   */
  constructor(element, stances, motion, show, showTime, follow) {
    this.stances = stances;
    this.count = stances.length;
    this.index = 0;
    this.motion = motion;
    this.time = 0;
    this.show = show;
    this.showTime = showTime;
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
    this.speed = el('select', { id: 'speed', title: 'Times as fast as the robot', 'aria-label': 'Speed' },
      SPEEDS.map((speed) => el('option', { value: speed }, `${speed}\u00d7`)));
    this.speed.value = SPEED;
    this.followButton = el('button', {
      type: 'button', id: 'follow', 'aria-pressed': 'false', title: 'The camera goes with the robot (F)', onclick: () => this.toggleFollow(),
    }, 'Follow');
    this.follow = follow;
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
        el('div', { class: 'counter' }, this.number, motion ? this.speed : [], this.followButton)),
      this.scroll = el('div', { class: 'schedule-scroll' }, grid));
    this.drawPlay();
  }

  /** Chooses a stance; the motion goes on from there. */
  set(index) {
    this.draw(index);
    this.time = this.motion?.reached(this.index) ?? 0;
  }

  draw(index) {
    this.choose(index);
    this.show(this.index);
  }

  /** Slider, number and schedule at a stance. */
  choose(index) {
    this.index = Math.min(Math.max(Math.round(index), 0), this.count - 1);
    this.slider.value = this.index;
    this.slider.setAttribute('aria-valuetext', `stance ${this.index} of ${this.count - 1}: ${describeChange(this.stances[this.index].change)}`);
    this.number.replaceChildren(el('b', {}, String(this.index)), ` / ${this.count - 1}`);
    this.grid.style.setProperty('--index', this.index);
    this.keepInSight(this.index);
  }

  /** A long schedule is scrolled to where the stance is. */
  keepInSight(index) {
    const { scroll } = this;
    if (!scroll || scroll.scrollWidth <= scroll.clientWidth) return;
    scroll.scrollLeft = ((index + 0.5) / this.count) * scroll.scrollWidth - 0.5 * scroll.clientWidth;
  }

  toggleFollow() {
    const on = this.followButton.getAttribute('aria-pressed') !== 'true';
    this.followButton.setAttribute('aria-pressed', String(on));
    this.follow(on);
  }

  step(by) {
    this.pause();
    this.set(this.index + by);
  }

  toggle() {
    if (this.timer) return this.pause();
    if (this.index === this.count - 1) this.set(0);
    if (this.motion) this.run();
    else {
      this.timer = setInterval(() => {
        this.set(this.index + 1);
        if (this.index === this.count - 1) this.pause();
      }, STEP_MS);
    }
    return this.drawPlay();
  }

  /** Plays the motion, a picture a frame of the browser's. */
  run() {
    let last = null;
    const frame = (now) => {
      this.timer = requestAnimationFrame(frame);
      this.seek(this.time + (Number(this.speed.value) * (now - (last ?? now))) / 1e3);
      last = now;
      if (this.time >= this.motion.duration) {
        this.pause();
        this.set(this.count - 1);
      }
    };
    this.timer = requestAnimationFrame(frame);
  }

  /** Shows the motion at a time, s, with the stance that is reached next. */
  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.motion.duration);
    const phase = this.motion.phase(this.time);
    if (phase.to !== this.index) this.choose(phase.to);
    const before = this.motion.reached(phase.from);
    const part = (this.time - before) / Math.max(this.motion.reached(phase.to) - before, 1e-6);
    this.grid.style.setProperty('--index', phase.from + part * (phase.to - phase.from));
    this.showTime(this.time, phase, this.timer !== null);
  }

  pause() {
    clearInterval(this.timer);
    cancelAnimationFrame(this.timer);
    this.timer = null;
    this.drawPlay();
  }

  drawPlay() {
    this.playButton.textContent = this.timer ? 'Pause' : 'Play';
    this.playButton.setAttribute('aria-pressed', String(Boolean(this.timer)));
  }
}
