// The goal: where the base shall be, within which distance, looking where.
import { Group } from 'three';
import { lineMaterial, segments } from './line.js';

const CORNERS = 48;

/** Nothing where the goal does not name a place; a free height is drawn at `baseHeight`, m. */
export function goalLayer(stage, goal, floor, baseHeight, name = 'goal') {
  const group = new Group();
  const [x, y, z] = goal.base_position_m ?? [];
  if (typeof x !== 'number' || typeof y !== 'number') return group;
  const top = typeof z === 'number' ? z : baseHeight;
  const line = lineMaterial(stage, name, { linewidth: 2 });
  const dashed = lineMaterial(stage, name, { linewidth: 1.4, dashed: true, dashSize: 0.04, gapSize: 0.03 });
  const circle = (height) => Array.from({ length: CORNERS }, (_, i) => [i, i + 1]).flat().flatMap((i) => {
    const angle = (2 * Math.PI * i) / CORNERS;
    return [x + goal.tolerance_m * Math.cos(angle), y + goal.tolerance_m * Math.sin(angle), height];
  });
  group.add(segments([x, y, floor, x, y, top], dashed), segments(circle(floor + 0.003), line), segments(circle(top), line));
  if (typeof goal.yaw_rad === 'number') {
    const [c, s] = [Math.cos(goal.yaw_rad), Math.sin(goal.yaw_rad)];
    const tip = [x + 0.28 * c, y + 0.28 * s, top];
    const barb = (side) => [...tip, tip[0] - 0.07 * c - side * 0.045 * s, tip[1] - 0.07 * s + side * 0.045 * c, top];
    group.add(segments([x, y, top, ...tip, ...barb(1), ...barb(-1)], line));
  }
  return group;
}
