// Switches of the layers, and the key to their colours.
import { heightScale } from './cloud.js';
import { el } from './dom.js';
import { AXIS_M, EDGE_KINDS } from './surfaces.js';
import { onTheme } from './theme.js';
import { barrierKey } from './tree.js';
import { count, metres, newtons } from './units.js';

/** One switch for each `[name, label, object, there]`; what is not there has no switch. */
export function layerSwitches(element, layers, invalidate) {
  for (const [name, label, object, there, on = true] of layers) {
    const apply = (visible) => {
      object.visible = visible;
      invalidate();
    };
    apply(there && on);
    if (!there) continue;
    const box = el('input', { type: 'checkbox', id: `layer-${name}`, checked: on, onchange: () => apply(box.checked) });
    element.append(el('label', {}, box, el('span', { class: `swatch ${name}` }), label));
  }
}

/** Layers that the key tells of too, in words of their own where the switch's are too few. */
const KEYED = [
  ['inset', 'surely there'],
  ['obstacle', 'obstacle'],
  ['unseen', 'not seen, kept away from'],
  ['ghost', 'stance before'],
  ['place', 'a place touched some time'],
  ['route', 'route of the base'],
  ['tree', 'the base at contact sets of the search'],
  ['goal', 'goal'],
];

const swatch = (name) => el('span', { class: `swatch ${name}` });

/** The height scale of the cloud, the scale of the forces and the colours of contacts and axes. */
export function colourKey(element, { data, range, scale, layers }) {
  const { cloud, surfaces, stances } = data;
  if (cloud) {
    const ramp = el('span', { class: 'ramp' });
    onTheme(() => { ramp.style.background = `linear-gradient(90deg, ${heightScale().join()})`; });
    const share = cloud.count < cloud.total ? `${count(cloud.count)} of ${count(cloud.total)}` : count(cloud.count);
    element.append(el('span', {}, 'height ', metres(range[0], 2), ramp, metres(range[1], 2)), el('span', {}, `${share} points`));
  }
  const stands = stances.length > 0 ? [
    el('span', {}, el('span', { class: 'sample' }), `contact force, 0.1 m = ${newtons(0.1 / scale)}`),
    el('span', {}, swatch('loaded'), 'loaded contact'),
    el('span', {}, swatch('unloaded'), 'no load'),
    el('span', {}, swatch('support'), 'where the centre of mass may be'),
  ] : [];
  const blocked = data.search.unsolved?.blocked?.length ? [el('span', {}, swatch('blocked'), 'contacts fail here')] : [];
  const refusals = barrierKey(data.trace);
  if (refusals.length) refusals[0] = [refusals[0][0], `refused by: ${refusals[0][1]}`];
  element.append(
    ...blocked,
    ...stands,
    ...KEYED.flatMap(([name, label]) => (layers.some((l) => l[0] === name && l[3]) ? [el('span', {}, swatch(name), label)] : [])),
    ...refusals.map(([name, says]) => el('span', {}, el('span', { class: `barrier ${name}` }), says)),
    ...edgeKey(surfaces),
    el('span', {}, ['x', 'y', 'z'].map((axis) => el('span', { class: `axis ${axis}` }, axis)), `frame, ${AXIS_M} m`),
  );
}

/** The kinds of edges that outlines of these surfaces have. */
function edgeKey(surfaces) {
  const there = new Set(surfaces.flatMap((surface) => surface.outline_edges.flat()));
  const shown = EDGE_KINDS.filter(({ name }) => there.has(name));
  return shown.length
    ? ['outline:', ...shown.map(({ name, label }) => el('span', {}, el('span', { class: `edge ${name}` }), label))]
    : [];
}
