// The way of the base that the search followed: a line at the base's height, a tick where it looks now and then.
import { Group } from 'three';
import { lineMaterial, segments } from './line.js';

const TICK_M = 0.12;
const APART_M = 0.4;

/** `route`: x, y, z and heading of each pose; nothing where there is none. */
export function routeLayer(stage, route) {
  const group = new Group();
  if (route.length < 2) return group;
  const line = lineMaterial(stage, 'route', { linewidth: 2.4, dashed: true, dashSize: 0.06, gapSize: 0.04 });
  const xyz = (pose) => pose.slice(0, 3);
  group.add(segments(route.slice(1).flatMap((pose, i) => [...xyz(route[i]), ...xyz(pose)]), line));
  let last = null;
  const far = ([x, y]) => last === null || Math.hypot(x - last[0], y - last[1]) > APART_M;
  const shown = route.filter((pose) => far(pose) && (last = pose));
  const tick = ([x, y, z, yaw]) => [x, y, z, x + TICK_M * Math.cos(yaw), y + TICK_M * Math.sin(yaw), z];
  group.add(segments(shown.flatMap(tick), lineMaterial(stage, 'route', { linewidth: 1.6 })));
  return group;
}
