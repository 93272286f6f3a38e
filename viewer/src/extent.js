// What of the scene matters to a view: the robot in every stance, the goal and the surfaces about.
import { Box3, Object3D, Vector3 } from 'three';
import { setPose } from './data.js';

/** A floor may be large: surfaces count this far around the way of the robot. */
const AROUND_M = 0.7;
/** Where a robot is yet to go, its base is about this high, m. */
const BASE_M = 0.8;

/**
 * `boxes`: the corners of a box around each body, in the body. Points to keep in view, their box's centre and
 * radius, the lowest height and the heading.
 */
export function extentOf(data, boxes) {
  const robot = data.stances.flatMap(({ poses, contacts }) => [
    ...bodyPoints(poses, boxes), ...contacts.flatMap((contact) => contact.vertices_W.map((v) => new Vector3(...v))),
  ]);
  const corners = data.surfaces.flatMap((surface) => surface.vertices_W.map((v) => new Vector3(...v)));
  const [gx, gy] = data.goal.base_position_m ?? [];
  if (typeof gx === 'number' && typeof gy === 'number' && robot.length) robot.push(new Vector3(gx, gy, robot[0].z));

  // Of a scan that is levelled the way begins about the origin, on z = 0.
  const { start, goal } = data.edit?.asked ?? {};
  if (!robot.length && start?.before_floor && goal?.base_position_m) {
    for (const [x, y] of [[0, 0], goal.base_position_m]) robot.push(new Vector3(x, y, 0), new Vector3(x, y, BASE_M));
  }

  // A large floor counts only where it is near the robot.
  const around = new Box3().setFromPoints(robot).expandByScalar(AROUND_M);
  const near = robot.length ? corners.map((corner) => around.clampPoint(corner, new Vector3())) : corners;
  const points = [...robot, ...near];
  if (!points.length) points.push(new Vector3());
  const box = new Box3().setFromPoints(points);
  const heights = [...corners, ...robot].map((point) => point.z);
  return {
    points,
    centre: box.getCenter(new Vector3()),
    radius: Math.max(0.5, 0.5 * box.getSize(new Vector3()).length()),
    floor: heights.length ? Math.min(...heights) : 0,
    heading: headingOf(data),
  };
}

/** The corners of the bodies' boxes in W. */
function bodyPoints(poses, boxes) {
  const body = new Object3D();
  return boxes.flatMap((corners, i) => {
    setPose(body, poses, 7 * i);
    body.updateMatrix();
    return corners.map((corner) => corner.clone().applyMatrix4(body.matrix));
  });
}

/** From the first base to the last; standing still, where the base looks at the start. */
function headingOf({ stances }) {
  if (!stances.length) return 0;
  const [first, last] = [stances[0].poses, stances[stances.length - 1].poses];
  const [dx, dy] = [last[0] - first[0], last[1] - first[1]];
  if (Math.hypot(dx, dy) > 0.1) return Math.atan2(dy, dx);
  const [x, y, z, w] = first.slice(3, 7);
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}
