// Decoding of the data that the page carries.

/** The plan's picture: the JSON of `scandent-view/1`, the cloud's positions decoded. */
export function readData(element) {
  const data = JSON.parse(element.textContent);
  if (data.format !== 'scandent-view/1') throw new Error(`unknown data format ${data.format}`);
  if (data.cloud) data.cloud.positions = decodeCloud(data.cloud);
  if (data.motion) data.motion.poses = decodePoses(data.motion, data.robot.bodies.length);
  return data;
}

/** Seven numbers a body and frame, from 32-bit floats (little endian). */
function decodePoses({ poses, frames }, bodies) {
  const bytes = decoded(poses);
  const count = 7 * bodies * frames;
  if (bytes.length !== 4 * count) throw new Error(`motion of ${frames} frames has ${bytes.length} bytes`);
  const floats = new DataView(bytes.buffer);
  return Float32Array.from({ length: count }, (_, i) => floats.getFloat32(4 * i, true));
}

function decoded(base64) {
  return Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
}

/** Positions in W, m, from 16-bit steps above the cloud's lower corner (little endian). */
function decodeCloud({ positions, count, origin_m: origin, step_m: step }) {
  const bytes = decoded(positions);
  if (bytes.length !== 6 * count) throw new Error(`cloud of ${count} points has ${bytes.length} bytes`);
  const steps = new DataView(bytes.buffer);
  const xyz = new Float32Array(3 * count);
  for (let i = 0; i < xyz.length; i++) xyz[i] = origin[i % 3] + step * steps.getUint16(2 * i, true);
  return xyz;
}

/** A pose as it stands in the data, `[x, y, z, qx, qy, qz, qw]`, put on an object. */
export function setPose(object, pose, at = 0) {
  object.position.fromArray(pose, at);
  object.quaternion.fromArray(pose, at + 3);
}

/** What the plan does to get to the stance, as a sentence. */
export function describeChange({ kind, patch, face }) {
  if (kind === 'start') return 'Start';
  if (kind === 'goal') return 'Goal reached';
  return kind === 'add' ? `${patch} made on ${face}` : `${patch} leaves ${face}`;
}
