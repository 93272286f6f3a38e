// The search: its tree through the places of the base, and what it was refused, coloured by what refused it.
import { BufferGeometry, Float32BufferAttribute, Group, Points, PointsMaterial } from 'three';
import { lineMaterial, segments } from './line.js';
import { colour, onTheme } from './theme.js';

/** What refuses a change, and under which colour of the style sheet. */
export const BARRIERS = {
  reach: { says: 'out of reach', name: 'place' },
  room: { says: 'no room on the face', name: 'place' },
  collision: { says: 'collision', name: 'collision' },
  balance: { says: 'balance', name: 'force' },
  friction: { says: 'friction', name: 'force' },
  torque: { says: 'torque', name: 'force' },
  joint_limit: { says: 'joint limit', name: 'joint' },
  tilt: { says: 'tilt of the base', name: 'joint' },
  motion: { says: 'no motion', name: 'motion' },
  goal: { says: 'no posture at the goal', name: 'goal' },
};
const POINT_PX = 8;
/** What is refused lies in faces, and the tree in the robot: both are drawn over them. */
const OVER = { depthTest: false, transparent: true };

/** What the colours stand for, of those that are there. */
export function barrierKey(trace) {
  const there = new Set((trace?.refused ?? []).map(({ by }) => BARRIERS[by].name));
  const says = { place: 'reach, room', collision: 'collision', force: 'balance, friction, torque', joint: 'joints, tilt', motion: 'no motion', goal: 'the goal' };
  return Object.entries(says).filter(([name]) => there.has(name));
}

/** `trace`: the tree, or null. */
export function treeLayer(stage, trace) {
  const group = new Group();
  if (!trace || trace.nodes.length < 2) return group;
  const { nodes, refused, choices } = trace;
  const edge = (node) => [...nodes[node.parent].base_W, ...node.base_W];
  const children = nodes.filter((node) => node.parent !== undefined);
  const lines = (some, material) => {
    if (some.length) group.add(segments(some.flatMap(edge), material));
  };
  lines(children.filter((node) => !node.cut), lineMaterial(stage, 'tree', { linewidth: 1.4, ...OVER }));
  lines(children.filter((node) => node.cut), lineMaterial(stage, 'refused-motion', { linewidth: 1.2, dashed: true, dashSize: 0.02, gapSize: 0.02, ...OVER }));
  const way = choices.map(({ node }) => nodes[node].base_W);
  const steps = way.slice(1).flatMap((to, i) => [...way[i], ...to]);
  if (steps.length) group.add(segments(steps, lineMaterial(stage, 'tree', { linewidth: 3.4, ...OVER })));
  group.add(dots(nodes.map((node) => node.base_W), 'tree', 4));
  for (const [name] of barrierKey(trace)) {
    const of = refused.filter(({ by }) => BARRIERS[by].name === name);
    group.add(dots(of.map(({ at_W: at }) => at), `refused-${name}`, POINT_PX));
  }
  return group;
}

function dots(places, name, size) {
  const geometry = new BufferGeometry().setAttribute('position', new Float32BufferAttribute(places.flat(), 3));
  const material = new PointsMaterial({ size, sizeAttenuation: false, opacity: 0.9, ...OVER });
  onTheme(() => material.color.set(colour(name)));
  return new Points(geometry, material);
}
