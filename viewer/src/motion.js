// The motion between the stances: every body's pose at any time, from the poses that the data has.
import { Quaternion, Vector3 } from 'three';

/** Numbers of one pose: x y z, qx qy qz qw. */
const POSE = 7;
/** A contact that bears no more than this is called slack, N. */
const SLACK_N = 1;
const from = new Quaternion();
const to = new Quaternion();
const place = new Vector3();
const next = new Vector3();

export class Motion {
  /** `record`: the motion of `scandent-view/1`, its poses decoded. */
  constructor({ step_s: step, frames, duration_s: duration, phases, poses, moments }) {
    Object.assign(this, { step, frames, duration, phases, poses, moments, bodies: poses.length / (POSE * frames) });
    this.out = new Float64Array(POSE * this.bodies);
  }

  /** Poses of all bodies at a time, s; the array is written anew at the next call. */
  at(time) {
    const steps = Math.min(Math.max(time / this.step, 0), this.frames - 1);
    const first = Math.min(Math.floor(steps), this.frames - 2);
    const part = steps - first;
    for (let body = 0; body < this.bodies; body++) {
      const a = POSE * (this.bodies * first + body);
      const b = a + POSE * this.bodies;
      place.fromArray(this.poses, a).lerp(next.fromArray(this.poses, b), part).toArray(this.out, POSE * body);
      from.fromArray(this.poses, a + 3).slerp(to.fromArray(this.poses, b + 3), part).toArray(this.out, POSE * body + 3);
    }
    return this.out;
  }

  /** What is done at a time: the later phase at a border. */
  phase(time) {
    return this.phases.findLast((phase) => phase.start_s <= time) ?? this.phases[0];
  }

  /** What holds the robot at a time: contacts as a stance has them, each with one force, at the nearest frame. */
  moment(time, stances) {
    const frame = Math.min(Math.round(time / this.step), this.frames - 1);
    const moment = this.moments[frame];
    const held = this.phase(Math.min(frame * this.step, this.duration));
    const phase = this.phase(time);
    const known = [...stances[held.to].contacts, ...stances[held.from].contacts];
    const contacts = held.contacts.flatMap(([patch, face], k) => {
      const contact = known.find((c) => c.patch === patch && c.face === face);
      if (!contact || !moment.contacts[k]) return [];
      const force = new Vector3().fromArray(moment.contacts[k]);
      const normal = force.dot(next.fromArray(contact.normal_W));
      const loaded = normal > SLACK_N;
      const across = Math.sqrt(Math.max(force.lengthSq() - normal * normal, 0));
      return [{
        ...contact, loaded, state: loaded ? 'bears' : 'slack', forces_W: [], force_points_W: [],
        force_W: force.toArray(), normal_N: normal,
        centre_of_pressure_W: loaded ? moment.contacts[k].slice(3) : null,
        friction_use: loaded ? across / (contact.friction * normal) : null,
      }];
    });
    return { time, duration: this.duration, phase, contacts, com_W: moment.com_W, torque_use: moment.torque_use };
  }

  /** When a stance is reached, s. */
  reached(stance) {
    return this.phases.findLast((phase) => phase.to <= stance)?.end_s ?? 0;
  }
}

/** What a phase does, as a sentence. */
export function describePhase({ kind, swing }) {
  if (kind === 'swing') return `${swing} swings`;
  return kind === 'shift' ? 'the weight shifts' : 'at rest';
}
