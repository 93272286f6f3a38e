// The margins of a stance against what the plan promises to keep.
import { degrees, millimetres, percent, scientific } from './units.js';

const AT_LIMIT = 0.02;

/** One row a margin: its name, the shown value and requirement, how full its bar is and its state. */
export function marginRows(stance, required) {
  const m = stance.margins;
  return [
    most('Friction used, of μ', m.friction_use, required.friction_use, percent),
    most('Torque used, of limit', m.torque_use, required.torque_use, percent),
    least('Joint range left', m.joint_rad, required.joint_rad, degrees),
    least('Clearance to scene', m.clearance_m, required.clearance_m, millimetres, 'none near'),
    least('Clearance to itself', m.self_clearance_m, required.self_clearance_m, millimetres, 'none near'),
    least('Patch inside surface', m.inclusion_m, 0, millimetres),
    // On level contacts the shrunk patches promise a distance; elsewhere only the forces do.
    stance.support?.level && isNumber(stance.support.com_promised_m)
      ? least('CoM inside support', stance.support.com_edge_m, stance.support.com_promised_m, millimetres)
      : plain('CoM inside support', stance.support?.com_edge_m, millimetres),
    plain('Contact closure', m.closure_m, (x) => millimetres(x, 3)),
    plain('Equilibrium, of weight', m.equilibrium, scientific),
  ];
}

const plain = (name, value, show) => ({ name, shown: isNumber(value) ? show(value) : '–' });

/** A use that must stay below its bound. */
function most(name, value, bound, show) {
  const row = { ...plain(name, value, show), bound: `≤ ${show(bound)}` };
  if (!isNumber(value)) return row;
  return { ...row, full: clamp(value), mark: clamp(bound), state: judge(bound - value, bound) };
}

/** A distance that must stay above its bound; `absent` stands where there is none. */
function least(name, value, bound, show, absent = '–') {
  const row = { ...plain(name, value, show), bound: `≥ ${show(bound)}` };
  if (!isNumber(value)) return { ...row, shown: absent };
  const scale = Math.max(4 * bound, 0.05);
  return { ...row, full: clamp(value / scale), mark: clamp(bound / scale), state: judge(value - bound, Math.max(bound, 0.01)) };
}

/** Rounding is not a violation: the posture is solved to a tolerance, and `verify` judges it. */
function judge(slack, size) {
  if (slack < -0.005 * size) return 'violated';
  return slack < AT_LIMIT * size ? 'at limit' : 'kept';
}

const isNumber = (x) => typeof x === 'number';
const clamp = (x) => Math.min(Math.max(x, 0), 1);
