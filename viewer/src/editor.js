// The panel of surfaces: who may touch which and why not, faces that are drawn, start and goal, and the files that
// come of it. Everything can be typed; what has a place can be clicked instead.
import { Group } from 'three';
import { el } from './dom.js';
import { polygonFace } from './drawn.js';
import { goalLayer } from './goal.js';
import { planner } from './serving.js';
import { lineMaterial, ring, segments } from './line.js';
import { toml } from './toml.js';
import { degrees } from './units.js';

const ROUND = 1000;
const number = (text) => (String(text).trim() === '' ? null : Number(text));
const rounded = (x) => Math.round(ROUND * x) / ROUND;
const isFriction = ({ friction }) => friction === undefined || (Number.isFinite(friction) && friction > 0);
const radians = (degree) => (degree * Math.PI) / 180;

export class Editor {
  constructor(element, data, picture) {
    Object.assign(this, { data, picture, edit: data.edit, clicks: null, drawn: 0 });
    this.asked = data.edit.asked ?? {};
    this.marks = new Group();
    picture.stage?.scene.add(this.marks);
    this.message = el('output', { id: 'said', 'aria-live': 'polite' });
    this.fields = this.form();
    this.command = el('pre', { id: 'command' });
    this.rows = el('tbody', {}, data.surfaces.map((surface) => this.row(surface)));
    element.classList.add('edit');
    element.append(
      el('h2', {}, 'Surfaces', el('small', {}, 'what may be touched, where to begin and where to go')),
      el('details', { open: true },
        el('summary', {}, `Faces (${data.surfaces.length})`),
        el('div', { class: 'faces', tabindex: 0, role: 'region', 'aria-label': 'Faces' }, el('table', {},
          el('thead', {}, el('tr', {}, ['face', 'for, friction', 'what its shape allows'].map((name) => el('th', { scope: 'col' }, name)))),
          this.rows))),
      this.drawing(),
      this.group('Robot', 'urdf', 'srdf', 'contacts', 'friction',
        el('datalist', { id: 'robots' }, this.edit.robots.map((value) => el('option', { value })))),
      this.group('Start of the base', 'start_x', 'start_y', 'start_yaw', this.placing('start')),
      this.group('Goal of the base', 'goal_x', 'goal_y', 'goal_yaw', 'tolerance', this.placing('goal')),
      this.group('Files', 'name',
        el('div', { class: 'row' },
          el('button', { type: 'button', id: 'save-scene', onclick: () => this.save('scene') }, 'Save the scene'),
          el('button', { type: 'button', id: 'save-surfaces', onclick: () => this.save('surfaces') }, 'Save the surfaces')),
        el('p', { class: 'note' }, 'Put both into one folder. Then, there:'), this.command),
      ...(this.edit.served ? [planner(() => this.files())] : []),
      this.message);
    element.addEventListener('input', () => this.changed());
    if (picture.stage) this.listen();
    this.changed();
  }

  form() {
    const { robot = {}, start = {}, goal = {}, friction = {} } = this.asked;
    const [gx, gy] = goal.base_position_m ?? [];
    const [sx, sy] = start.over_m ?? [];
    const inDegrees = (rad) => (typeof rad === 'number' ? rounded((180 * rad) / Math.PI) : '');
    const given = this.edit.robots.filter((name) => !name.startsWith('builtin:'));
    const values = {
      urdf: ['URDF', robot.urdf ?? (given.length === 1 ? given[0] : 'builtin:hrp2')], srdf: ['SRDF', robot.srdf ?? ''], contacts: ['contacts', robot.contacts ?? ''],
      friction: ['friction', friction.default ?? ''],
      start_x: ['x, m', sx ?? ''], start_y: ['y, m', sy ?? ''], start_yaw: ['heading, °', sx === undefined ? '' : inDegrees(start.yaw_rad)],
      goal_x: ['x, m', gx ?? ''], goal_y: ['y, m', gy ?? ''], goal_yaw: ['heading, °', inDegrees(goal.yaw_rad)],
      tolerance: ['within, m', goal.tolerance_m ?? 0.1],
      name: ['name', this.data.scene.replace(/^.*\//, '').replace(/\.[a-z.]+$/i, '').replace(/[^A-Za-z0-9_-]+/g, '-').slice(0, 60) || 'scene'],
    };
    const fields = Object.fromEntries(Object.entries(values).map(([id, [label, value]]) =>
      [id, { label, input: el('input', { id, value, autocomplete: 'off', spellcheck: 'false' }) }]));
    fields.urdf.input.setAttribute('list', 'robots');
    return fields;
  }

  group(title, ...content) {
    return el('fieldset', {}, el('legend', {}, title), content.map((part) =>
      (typeof part === 'string' ? el('label', {}, el('span', {}, this.fields[part].label), this.fields[part].input) : part)));
  }

  value(name) {
    return this.fields[name].input.value.trim();
  }

  /** A face's row: who may touch it, and what its shape lets and does not let it serve for. */
  row(surface) {
    const record = this.faceRecord(surface.id);
    const { roles } = this.edit;
    const choice = el('select', {
      'aria-label': `who may touch ${surface.id}`,
      onchange: () => {
        if (choice.value === 'shape') delete record.roles;
        else record.roles = choice.value === 'nothing' ? [] : [choice.value];
        this.changed();
      },
    }, [['shape', 'by shape'], ['nothing', 'nothing'], ...roles.map((role) => [role, role])]
      .map(([value, label]) => el('option', { value }, label)));
    const friction = el('input', {
      'aria-label': `friction of ${surface.id}, at most`, class: 'mu', inputmode: 'decimal', autocomplete: 'off', placeholder: 'patch’s', value: record.friction,
      oninput: () => {
        record.friction = number(friction.value) ?? undefined;
        friction.setAttribute('aria-invalid', String(!isFriction(record)));
      },
    });
    choice.value = record.roles ? record.roles[0] ?? 'nothing' : 'shape';
    const verdict = ({ role, why_not: why }) => el('div', {}, el('b', {}, role), why ? `: ${why}` : ': yes');
    const point = (id) => () => this.picture.point(id);
    return el('tr', {
      onmouseenter: point(surface.id), onmouseleave: point(null), onfocusin: point(surface.id), onfocusout: point(null),
    },
    el('th', { scope: 'row' }, surface.id, el('small', {}, `${surface.area_m2.toFixed(2)} m², ${degrees(surface.tilt_rad, 0)}`)),
    el('td', {}, choice, el('label', { class: 'mu' }, 'μ ≤', friction)),
    el('td', { class: 'why' }, surface.serves?.map(verdict) ?? 'drawn'));
  }

  faceRecord(id) {
    return this.edit.terrain.faces.find((face) => face.id === id);
  }

  drawing() {
    this.corners = el('textarea', { id: 'corners', rows: 3, 'aria-label': 'corners of the face: x y z in m, one a line', spellcheck: 'false', placeholder: 'x y z of a corner, m; one a line' });
    this.drawButton = el('button', {
      type: 'button', id: 'draw', 'aria-pressed': 'false', onclick: () => this.take(this.clicks === 'draw' ? null : 'draw'),
    }, 'Click corners');
    return el('fieldset', {}, el('legend', {}, 'Draw a face'), this.corners,
      el('div', { class: 'row' }, this.drawButton,
        el('button', { type: 'button', id: 'add', onclick: () => this.addFace() }, 'Add the face')));
  }

  placing(what) {
    const button = el('button', {
      type: 'button', id: `place-${what}`, 'aria-pressed': 'false', onclick: () => this.take(this.clicks === what ? null : what),
    }, 'Click the place');
    this[`${what}Button`] = button;
    return el('div', { class: 'row' }, button);
  }

  /** What clicks into the picture mean from now on: corners, start or goal; null: nothing. */
  take(what) {
    this.clicks = what;
    for (const [name, button] of [['draw', this.drawButton], ['start', this.startButton], ['goal', this.goalButton]]) {
      button.setAttribute('aria-pressed', String(name === what));
    }
  }

  listen() {
    const canvas = this.picture.stage.renderer.domElement;
    let down = null;
    canvas.addEventListener('pointerdown', (event) => { down = [event.clientX, event.clientY]; });
    canvas.addEventListener('pointerup', (event) => {
      // A drag turns the view.
      if (!this.clicks || !down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      const under = this.picture.under(event, 0);
      if (!under) return;
      const [x, y, z] = under.point.toArray().map(rounded);
      if (this.clicks === 'draw') this.corners.value += `${this.corners.value && !this.corners.value.endsWith('\n') ? '\n' : ''}${x} ${y} ${z}\n`;
      else {
        this.fields[`${this.clicks}_x`].input.value = x;
        this.fields[`${this.clicks}_y`].input.value = y;
        this.take(null);
      }
      this.changed();
    });
  }

  points() {
    const rows = this.corners.value.split('\n').filter((line) => line.trim());
    return rows.map((line) => line.trim().split(/[\s,]+/).map(Number));
  }

  addFace() {
    try {
      do this.drawn += 1; while (this.faceRecord(`drawn-${this.drawn}`));
      const { record, surface } = polygonFace(`drawn-${this.drawn}`, this.points());
      this.edit.terrain.faces.push(record);
      this.picture.surfaces?.add(surface);
      this.picture.surfaces?.paint();
      this.rows.append(this.row(surface));
      this.corners.value = '';
      this.take(null);
      this.say(`${record.id} was added`);
    } catch (error) {
      this.say(error.message, true);
    }
    this.changed();
  }

  say(text, bad = false) {
    this.message.textContent = text;
    this.message.classList.toggle('bad', bad);
  }

  /** The texts of scene.toml and surfaces.json. */
  files() {
    const { start: given = {}, goal: wanted = {}, friction = {}, settings = '' } = this.asked;
    const slippery = this.edit.terrain.faces.find((face) => !isFriction(face));
    if (slippery) throw new Error(`the friction of ${slippery.id} is no positive number`);
    const at = (what) => ['x', 'y'].map((axis) => number(this.value(`${what}_${axis}`)));
    const yaw = (what) => number(this.value(`${what}_yaw`));
    const [begin, end, name] = [at('start'), at('goal'), this.value('name')];
    const numbers = [...begin, ...end, yaw('start'), yaw('goal'), number(this.value('tolerance')), number(this.value('friction'))];
    if (numbers.some((x) => x !== null && !Number.isFinite(x))) throw new Error('a place, a heading or the friction is no number');
    if (end.includes(null) && !wanted.contact?.length) throw new Error('the goal has no place yet: type x and y, or click');
    if (begin.includes(null) && begin.some((x) => x !== null)) throw new Error('the start has one of x and y');
    const robot = { urdf: this.value('urdf') };
    for (const file of ['srdf', 'contacts']) if (this.value(file)) robot[file] = this.value(file);
    const start = begin.includes(null) ? given : { over_m: begin, yaw_rad: radians(yaw('start') ?? 0), ...(given.posture && { posture: given.posture }) };
    const goal = { ...wanted, tolerance_m: number(this.value('tolerance')) ?? 0.1 };
    const [wx, wy, ...height] = wanted.base_position_m ?? [];
    if (!end.includes(null)) goal.base_position_m = end[0] === wx && end[1] === wy ? [wx, wy, ...height] : end;
    delete goal.yaw_rad;
    if (yaw('goal') !== null) goal.yaw_rad = radians(yaw('goal'));
    const rub = { ...friction };
    delete rub.default;
    if (number(this.value('friction')) !== null) rub.default = number(this.value('friction'));
    const scene = { name, surfaces_file: `${name}.surfaces.json`, robot, start, goal, friction: rub };
    const lines = Object.entries(scene).filter(([, value]) => Object.keys(value).length).map(([key, value]) => `${key} = ${toml(value)}\n`);
    return { name, scene: `${lines.join('')}\n${settings}`, surfaces: this.edit.terrain };
  }

  save(what) {
    try {
      const { name, scene, surfaces } = this.files();
      const [file, text] = what === 'scene' ? [`${name}.toml`, scene] : [`${name}.surfaces.json`, JSON.stringify(surfaces)];
      const address = URL.createObjectURL(new Blob([text], { type: 'text/plain' }));
      el('a', { href: address, download: file }).click();
      setTimeout(() => URL.revokeObjectURL(address), 10_000);
      this.say(`saved: ${file}`);
    } catch (error) {
      this.say(error.message, true);
    }
  }

  /** Redraws what the form says: start, goal, corners, faces that nothing may touch, the command. */
  changed() {
    const name = this.value('name');
    this.command.textContent = `scandent plan ${name}.toml -o out/${name}`;
    const { stage, surfaces } = this.picture;
    if (!stage) return;
    surfaces.setOff(this.edit.terrain.faces.filter((face) => face.roles?.length === 0).map((face) => face.id));
    for (const part of this.marks.children) part.traverse((node) => node.geometry?.dispose());
    this.marks.clear();
    for (const what of ['start', 'goal']) {
      const place = ['x', 'y'].map((axis) => number(this.value(`${what}_${axis}`)));
      const heading = number(this.value(`${what}_yaw`));
      if (place.some((x) => x === null || !Number.isFinite(x))) continue;
      const drawn = { base_position_m: place, tolerance_m: what === 'goal' ? number(this.value('tolerance')) || 0.1 : 0.05, yaw_rad: radians(heading ?? 0) };
      this.marks.add(goalLayer(stage, drawn, 0, 0.8, what === 'goal' ? 'goal' : 'route'));
    }
    const corners = this.points().filter((point) => point.length === 3 && point.every(Number.isFinite));
    this.cornerLine ??= lineMaterial(stage, 'force', { linewidth: 2.5, depthTest: false });
    if (corners.length > 1) this.marks.add(segments(ring(corners), this.cornerLine));
    stage.invalidate();
  }
}
