// The side panel: facts of the stance, then of the plan.
import { marginRows } from './margins.js';
import { supportPlot } from './support_plot.js';
import { describeChange } from './data.js';
import { el } from './dom.js';
import { describePhase } from './motion.js';
import { term } from './terms.js';
import { choiceSection } from './why.js';
import { count, degrees, metres, millimetres, newtons, percent } from './units.js';

const STATES = {
  loaded: 'loaded', bears: 'bears', slack: 'no load', made: 'just made, no load', leaving: 'about to leave, no load', touching: 'touching, no load',
};

export class Panel {
  /** `point` is called with the id of the surface that the reader points at, or null. */
  constructor(element, data, point) {
    this.data = data;
    this.stanceBox = el('div', { class: 'stance-box' });
    element.append(
      unsolvedSection(data.search),
      this.stanceBox,
      ...(data.kind === 'robot' ? [] : [
        section('Search', facts(searchFacts(data))),
        section('Goal', facts(goalFacts(data.goal)))]),
      surfaceTable(data, point),
      ...(data.kind === 'robot' ? [] : [
        inputList(data), el('p', { class: 'foot', id: 'verdict' }, verdict(data.certificate))]),
    );
  }

  show(stance) {
    const { data } = this;
    this.stanceBox.replaceChildren(
      el('h2', {}, `Stance ${stance.index}`, el('small', {}, describeChange(stance.change))),
      section('Contacts', contactTable(stance)),
      ...choiceSection(data.trace, stance, data.stances.length),
      section('Margins', marginTable(marginRows(stance, data.required))),
      section('Support region, from above', supportPlot(stance), supportNote(stance, data)),
    );
  }

  /** An instant between two stances: what holds the robot then. */
  showMoment({ time, duration, phase, contacts, com_W: com, torque_use: torque }) {
    const uses = contacts.map((contact) => contact.friction_use).filter((use) => use !== null);
    const { required } = this.data;
    this.stanceBox.replaceChildren(
      el('h2', {}, `${time.toFixed(1)} s`, el('small', {}, `of ${duration.toFixed(1)} s, to stance ${phase.to}: ${describePhase(phase)}`)),
      section('Contacts now', contactTable({ contacts })),
      section('Now', el('dl', {}, [
        ['Friction used, of μ', uses.length ? percent(Math.max(...uses)) : '–', `≤ ${percent(required.friction_use)} at rest`],
        ['Torque used, of limit', percent(torque), `≤ ${percent(required.torque_use)} at rest`],
        ['Centre of mass', com.map((x) => x.toFixed(2)).join(', ').replaceAll('-', '\u2212') + ' m'],
      ].map(([name, value, bound]) => [el('dt', {}, term(name)), el('dd', {}, value, bound && el('small', {}, ` ${bound}`))]))),
      el('p', { class: 'note' }, 'Clearances and the support region are told for stances: pause, or step to one.'),
    );
  }
}

const section = (title, ...content) => el('section', {}, el('h3', {}, term(title)), content);

/** Why there is no plan, and what to try. */
function unsolvedSection({ unsolved }) {
  if (!unsolved) return '';
  const list = (lines) => el('ul', {}, lines.map((line) => el('li', {}, line)));
  return el('div', { class: 'why', id: 'why' },
    el('h2', {}, 'No plan', el('small', {}, unsolved.sentence)),
    section(unsolved.status === 'refused' ? 'What the verifier refuses' : 'What blocks the way', list(unsolved.reasons)),
    section('What to try', list(unsolved.to_try)));
}

/** What the verifier made of the plan, and on which terms. */
function verdict(certificate) {
  if (!certificate) {
    return ['The margins are those of the plan file; ', el('code', {}, 'scandent verify'),
      ' recomputes and judges them.'];
  }
  const { verdict, checks, conditions } = certificate;
  return [`The verifier: ${verdict}, ${checks} checks.`, el('ul', {}, conditions.map((line) => el('li', {}, line)))];
}

const facts = (rows) =>
  el('dl', {}, rows.map(([name, value]) => [el('dt', {}, term(name)), el('dd', {}, value)]));

const head = (...names) =>
  el('thead', {}, el('tr', {}, names.map((name) => el('th', { scope: 'col' }, term(name)))));

function contactTable({ contacts }) {
  if (!contacts.length) return el('p', { class: 'note' }, 'No contacts.');
  return el('table', { class: 'contacts' },
    head('patch', 'surface', 'normal', 'friction'),
    el('tbody', {}, contacts.map((contact) => el('tr', {},
      el('th', { scope: 'row' },
        el('span', { class: `dot ${contact.loaded ? 'loaded' : 'unloaded'}` }),
        contact.patch, el('small', {}, STATES[contact.state])),
      el('td', {}, contact.face),
      el('td', { class: 'number' }, contact.loaded ? newtons(contact.normal_N) : '–'),
      el('td', { class: 'number' }, frictionText(contact), el('small', {}, `μ = ${contact.friction}`))))));
}

function frictionText({ loaded, friction_use: use }) {
  return loaded && typeof use === 'number' ? percent(use, 0) : '–';
}

function marginTable(rows) {
  return el('table', { class: 'margins' },
    head('worst in this stance', 'value', 'required'),
    el('tbody', {}, rows.map((row) => el('tr', { class: row.state?.replace(' ', '-') },
      el('th', { scope: 'row' }, term(row.name), meter(row)),
      el('td', { class: 'number' }, row.shown),
      el('td', { class: 'number' }, row.bound ?? '', row.state && el('span', { class: 'state' }, row.state))))));
}

/** A bar with a mark at the required value. */
function meter({ full, mark }) {
  if (full === undefined) return null;
  const bar = el('span', { class: 'meter', 'aria-hidden': 'true' }, el('i'), el('b'));
  bar.firstChild.style.width = `${100 * full}%`;
  bar.lastChild.style.left = `${100 * mark}%`;
  return bar;
}

function supportNote(stance, { required }) {
  const kept = `the patches shrunk by up to ${millimetres(required.com_m, 0)} and ${percent(required.friction_use, 0)} of the friction`;
  const ground = `Drawn in the 3-D view at the height of the lowest loaded contact, ${metres(stance.support_level_m, 2)}.`;
  if (!stance.support) {
    return el('p', { class: 'note bad' }, 'No CoM position is in static equilibrium on the loaded contacts.');
  }
  const what = stance.support.level
    ? 'The loaded contacts are level and coplanar: the region is the convex hull of their vertices, projected on the ground.'
    : 'The loaded contacts are not in one level plane: the region is where the CoM may stand for contact forces inside the friction cones (8-sided, inscribed) to balance gravity.';
  return el('p', { class: 'note' }, `${what} Dashed: with ${kept}. Torque limits are not part of it. ${ground}`);
}

function searchFacts({ search, stances, seed }) {
  return [
    [search.unsolved ? 'Stances so far' : 'Stances in the plan', count(stances.length)],
    ['Contact sets on the path', count(search.path_stances)],
    ['Nodes generated', count(search.nodes_generated)],
    ['Nodes expanded', count(search.nodes_expanded)],
    ['Posture problems solved', count(search.candidates_solved)],
    ['Seed', String(seed)],
  ];
}

function goalFacts(goal) {
  const rows = [];
  if (goal.base_position_m) {
    const axes = goal.base_position_m.map((v) => (typeof v === 'number' ? v.toFixed(2) : 'free'));
    rows.push(['Base at x, y, z', `${axes.join(', ').replaceAll('-', '\u2212')} m`]);
    rows.push(['Within', metres(goal.tolerance_m, 2)]);
  }
  if (typeof goal.yaw_rad === 'number') rows.push(['Heading', degrees(goal.yaw_rad)]);
  for (const { patch, face } of goal.contacts) rows.push(['Contact', `${patch} on ${face}`]);
  if (goal.joints) {
    const { wanted, tolerance_rad: within } = goal.joints;
    rows.push(['Joints', `${count(Object.keys(wanted).length)} within ${within.toFixed(3)} rad`]);
  }
  return rows.length ? rows : [['Goal', 'none']];
}

function surfaceTable({ surfaces, kind }, point) {
  const row = (surface) => el('tr', {
    tabindex: 0,
    onmouseenter: () => point(surface.id), onmouseleave: () => point(null),
    onfocus: () => point(surface.id), onblur: () => point(null),
  },
  el('th', { scope: 'row' }, surface.id, el('small', {}, surface.friction ? `${surface.source}, μ ≤ ${surface.friction}` : surface.source)),
  el('td', { class: 'number' }, surface.X_WS[2].toFixed(3).replace('-', '\u2212')),
  el('td', { class: 'number' }, degrees(surface.tilt_rad)),
  el('td', { class: 'number' }, surface.area_m2.toFixed(3)),
  el('td', { class: 'number' }, (1000 * surface.inset_m).toFixed(0)),
  el('td', { class: 'number' }, surface.inliers ? (1000 * surface.rms_m).toFixed(1) : '–'));
  return el('details', { open: true },
    el('summary', {}, `${kind === 'robot' ? 'Contact patches' : 'Surfaces'} (${surfaces.length})`),
    el('div', { class: 'scroll' }, el('table', { class: 'surfaces' },
      head('id', 'height m', 'tilt', 'area m²', 'inset mm', 'RMS mm'),
      el('tbody', {}, surfaces.map(row)))));
}

function inputList({ inputs, program }) {
  return el('details', {},
    el('summary', {}, `Made from (${inputs.length} files)`),
    el('ul', { class: 'inputs' }, inputs.map((input) => el('li', {},
      el('b', {}, input.role), ` ${input.name}`, el('code', { title: input.sha256 }, `sha256 ${input.sha256.slice(0, 16)}…`)))),
    el('p', { class: 'note' }, `Planned by ${program}.`));
}
