// A face from the corners that someone drew.
import { Matrix4, Quaternion, ShapeUtils, Vector2, Vector3 } from 'three';

/** Corners may be off their plane by this, m. */
const FLAT_M = 0.02;
const SMALLEST_M2 = 1e-3;

/** The record of surfaces.json and what the picture needs of it, from corners in W, m; its normal looks up. */
export function polygonFace(id, corners) {
  if (corners.length < 3) throw new Error('a face has three corners or more: x y z, one a line');
  if (corners.some((corner) => corner.length !== 3 || !corner.every(Number.isFinite))) throw new Error('a corner is three numbers: x y z, m');
  const points = corners.map((corner) => new Vector3(...corner));
  const middle = points.reduce((sum, p) => sum.add(p), new Vector3()).divideScalar(points.length);
  // Twice the area times the normal.
  const turned = points.reduce((sum, p, i) => {
    const q = points[(i + 1) % points.length];
    return sum.add(p.clone().sub(middle).cross(q.clone().sub(middle)));
  }, new Vector3());
  if (turned.length() < 2 * SMALLEST_M2) throw new Error('these corners enclose no area');
  const normal = turned.clone().normalize();
  if (normal.z < -1e-9) {
    normal.negate();
    points.reverse();
  }
  const off = Math.max(...points.map((p) => Math.abs(p.clone().sub(middle).dot(normal))));
  if (off > FLAT_M) throw new Error(`these corners are ${(1000 * off).toFixed(0)} mm off one plane`);
  const ahead = Math.abs(normal.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
  const x = ahead.addScaledVector(normal, -ahead.dot(normal)).normalize();
  const y = normal.clone().cross(x);
  const turn = new Quaternion().setFromRotationMatrix(new Matrix4().makeBasis(x, y, normal));
  const polygon = points.map((p) => {
    const from = p.clone().sub(middle);
    return [from.dot(x), from.dot(y)];
  });
  const flat = polygon.map(([a, b]) => new Vector2(a, b));
  const triangles = ShapeUtils.triangulateShape(flat, []).map((t) => t.map((k) => polygon[k]));
  const quat = turn.toArray();
  return {
    record: { id, X_WF: { p: middle.toArray(), quat_xyzw: quat }, polygon },
    surface: {
      id, X_WS: [...middle.toArray(), ...quat], triangles, effective: [], outline: [polygon],
      outline_edges: [polygon.map(() => 'real')], area_m2: Math.abs(ShapeUtils.area(flat)),
      tilt_rad: Math.acos(Math.min(1, normal.z)), vertices_W: corners,
    },
  };
}
