// Where the camera stands: views that fit what matters, and the keys that move it.
import { Spherical, Vector3 } from 'three';

/** Directions from the target to the camera: ahead, left, up in the plan's heading. */
export const VIEWS = [
  { name: 'front-right', label: 'Front right', towards: [0.62, -1, 0.62] },
  { name: 'right', label: 'Right', towards: [0, -1, 0.12] },
  { name: 'front', label: 'Front', towards: [1, 0, 0.3] },
  { name: 'rear-left', label: 'Rear left', towards: [-0.75, 0.85, 0.7] },
  { name: 'top', label: 'Top', towards: [-0.001, 0, 1] },
];
const MARGIN = 1.06;
/** From how far a camera follows the robot, m. */
const FOLLOWED_M = 4;

export class Viewpoint {
  /** `points`: what a view must show, in W; `heading`: the plan's direction in the plane, rad. */
  constructor(stage, points, heading) {
    this.stage = stage;
    this.points = points;
    this.heading = heading;
    this.view = VIEWS[0];
    this.moved = false;
    this.listeners = [];
    stage.controls.addEventListener('start', () => this.release());
    stage.resizeListeners.push(() => { if (!this.moved) this.fit(); });
  }

  /** The camera is the reader's from here on. */
  release() {
    this.moved = true;
    for (const listener of this.listeners) listener(null);
  }

  go(name) {
    this.view = VIEWS.find((view) => view.name === name) ?? VIEWS[0];
    this.moved = false;
    this.followed = null;
    this.fit();
    for (const listener of this.listeners) listener(this.view.name);
  }

  /** The nearest place in the view's direction from which every point is in the picture. */
  fit() {
    const { camera, controls } = this.stage;
    const [ahead, left, up] = this.view.towards;
    const [c, s] = [Math.cos(this.heading), Math.sin(this.heading)];
    const back = new Vector3(c * ahead - s * left, s * ahead + c * left, up).normalize();
    const right = new Vector3(0, 0, 1).cross(back).normalize();
    const above = back.clone().cross(right);
    const tanY = Math.tan((camera.fov * Math.PI) / 360) / MARGIN;
    const tanX = tanY * camera.aspect;

    // Each point bounds the camera's place along an axis from both sides; the target is the middle.
    const extent = (axis, tan) => {
      let [low, high] = [Infinity, -Infinity];
      for (const p of this.points) {
        const [a, depth] = [p.dot(axis), p.dot(back)];
        low = Math.min(low, a - tan * depth);
        high = Math.max(high, a + tan * depth);
      }
      // At camera depth d: a − tan (d − depth) ≤ x ≤ a + tan (d − depth) for every point.
      return { centre: 0.5 * (low + high), distance: (high - low) / (2 * tan) };
    };
    const [x, y] = [extent(right, tanX), extent(above, tanY)];
    const depth = Math.max(x.distance, y.distance);
    const eye = new Vector3()
      .addScaledVector(right, x.centre).addScaledVector(above, y.centre).addScaledVector(back, depth);
    const middle = this.points.reduce((sum, p) => sum + p.dot(back), 0) / this.points.length;
    controls.target.copy(eye).addScaledVector(back, middle - depth);
    camera.position.copy(eye);
    controls.update();
    this.stage.invalidate();
  }

  /** Keeps a point where it is in the picture as it moves; null lets go. */
  follow(point) {
    const { camera, controls } = this.stage;
    if (point && this.followed) {
      const moved = point.clone().sub(this.followed);
      controls.target.add(moved);
      camera.position.add(moved);
      controls.update();
    } else if (point) {
      // From now on: nearer, with the robot in the middle.
      const towards = camera.position.clone().sub(controls.target).setLength(FOLLOWED_M);
      controls.target.copy(point);
      camera.position.copy(point).add(towards);
      controls.update();
    }
    if (point) this.moved = true;
    this.followed = point && point.clone();
    if (!point && this.view) this.go(this.view.name);
  }

  /** Turns about the target by angles, rad. */
  orbit(azimuth, elevation) {
    this.change((spherical) => {
      spherical.theta += azimuth;
      spherical.phi = Math.min(Math.max(spherical.phi - elevation, 0.02), Math.PI - 0.02);
    });
  }

  zoom(factor) {
    this.change((spherical) => { spherical.radius *= factor; });
  }

  change(edit) {
    const { camera, controls } = this.stage;
    const offset = camera.position.clone().sub(controls.target);
    // Spherical speaks y up.
    const spherical = new Spherical().setFromCartesianCoords(offset.y, offset.z, offset.x);
    edit(spherical);
    const turned = new Vector3().setFromSpherical(spherical);
    camera.position.copy(controls.target).add(new Vector3(turned.z, turned.x, turned.y));
    controls.update();
    this.release();
  }
}
