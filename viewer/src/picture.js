// The 3-D picture: the layers of the data, the camera, and what of them belongs to a stance or an instant.
import { Group, Plane, Raycaster, Vector2, Vector3 } from 'three';
import { BalanceLayer } from './balance.js';
import { Viewpoint } from './camera.js';
import { cloudLayer, heightRange } from './cloud.js';
import { ContactsLayer } from './contacts.js';
import { el } from './dom.js';
import { extentOf } from './extent.js';
import { goalLayer } from './goal.js';
import { colourKey, layerSwitches } from './layers.js';
import { bodiesLayer } from './obstacles.js';
import { RobotLayer } from './robot.js';
import { routeLayer } from './route.js';
import { Stage } from './stage.js';
import { SurfacesLayer } from './surfaces.js';
import { treeLayer } from './tree.js';

/** A stage narrower than this starts with its box of layers closed. */
const ROOMY_PX = 800;
const OBSTACLE_OPACITY = 0.5;
const UNSEEN_OPACITY = 0.16;

const $ = (id) => document.getElementById(id);

export class Picture {
  constructor(data) {
    this.data = data;
    const robot = new RobotLayer(data.robot);
    const extent = extentOf(data, robot.boxes());
    const stage = new Stage($('stage'), $('view'), $('labels'), extent);
    this.viewpoint = new Viewpoint(stage, extent.points, extent.heading);
    const range = data.cloud ? heightRange(data.cloud.positions) : null;
    const cloud = data.cloud ? cloudLayer(data.cloud.positions, range) : new Group();
    const surfaces = new SurfacesLayer(stage, data.surfaces);
    const seen = data.obstacles.filter((body) => !body.assumed);
    const assumed = data.obstacles.filter((body) => body.assumed);
    const obstacles = bodiesLayer(seen, 'obstacle', OBSTACLE_OPACITY);
    const unseen = bodiesLayer(assumed, 'unseen', UNSEEN_OPACITY);
    const behind = bodiesLayer(data.unseen, 'unseen', UNSEEN_OPACITY);
    const ghost = new Group().add(robot.ghost);
    const contacts = new ContactsLayer(stage, data);
    const balance = new BalanceLayer(stage, data.stances);
    const goal = goalLayer(stage, data.goal, extent.floor, data.stances.at(-1)?.poses[2] ?? extent.floor);
    const route = routeLayer(stage, data.search.route ?? []);
    const tree = treeLayer(stage, data.trace);
    stage.scene.add(route, tree, cloud, surfaces.fill, surfaces.inset, surfaces.frames, surfaces.names, obstacles, unseen, behind,
      robot.solid, ghost, contacts.patches, contacts.forces, contacts.places, balance.group, balance.path, goal);
    surfaces.setBlocked(data.search.unsolved?.blocked ?? []);

    const [ofRobot, moves] = [data.kind === 'robot', data.stances.length > 1];
    const stands = data.stances.length > 0;
    this.layers = [
      ['cloud', ofRobot ? 'Reach of the patches' : 'Scan', cloud, data.cloud !== null],
      ['surface', ofRobot ? 'Contact patches' : 'Surfaces', surfaces.fill, true],
      ['inset', ofRobot ? 'Outlines' : 'Inset polygons', surfaces.inset, true],
      ['frames', 'Frames', surfaces.frames, true],
      ['names', 'Names', surfaces.names, true],
      ['obstacle', 'Obstacles', obstacles, seen.length > 0],
      ['unseen', 'Assumed beyond the view', unseen, assumed.length > 0],
      ['behind', 'Unseen behind faces', behind, data.unseen.length > 0, false],
      ['robot', 'Robot', robot.solid, data.robot.bodies.length > 0],
      ['ghost', 'Previous stance', ghost, moves],
      ['contact', 'Contacts', contacts.patches, stands],
      ['force', 'Forces', contacts.forces, stands],
      ['support', 'CoM and support', balance.group, stands],
      ['place', 'All footholds', contacts.places, moves],
      ['path', 'CoM path', balance.path, moves, false],
      ['route', 'Route of the base', route, route.children.length > 0],
      ['tree', 'Search tree', tree, tree.children.length > 0, Boolean(data.search.unsolved)],
      ['goal', 'Goal', goal, goal.children.length > 0],
    ];
    layerSwitches($('layers'), this.layers, () => stage.invalidate());
    colourKey($('key'), { data, range, scale: contacts.scale, layers: this.layers });
    $('key-box').open = innerWidth > ROOMY_PX;
    const box = $('layers-box');
    box.open = stage.width > ROOMY_PX;
    const reserve = () => stage.reserve(box.open && stage.width > ROOMY_PX ? box.offsetWidth : 0);
    box.addEventListener('toggle', reserve);
    reserve();
    Object.assign(this, { stage, robot, surfaces, obstacles, unseen, behind, ghost, contacts, balance, follows: false });
    stage.beforeDraw.push(() => this.fade());
    if (!stands) for (const part of [robot.solid, ghost, balance.group]) part.visible = false;
  }

  point(id) {
    this.surfaces.point(id);
    this.stage.invalidate();
  }

  show(stance, before) {
    RobotLayer.pose(this.robot.solid, stance.poses);
    this.robot.ghost.visible = before !== undefined;
    if (before) RobotLayer.pose(this.robot.ghost, before.poses);
    this.hold(stance, stance.support_level_m);
  }

  /** An instant between stances, the robot's bodies at `poses`. */
  showMoment(moment, poses, level) {
    RobotLayer.pose(this.robot.solid, poses);
    this.robot.ghost.visible = false;
    this.hold(moment, level);
  }

  hold(held, level) {
    this.surfaces.setUsed(held.contacts.map((contact) => contact.face));
    this.contacts.show(held);
    this.balance.show(held, level);
    if (this.follows) this.viewpoint.follow(this.balance.mark.position);
    this.stage.invalidate();
  }

  /** Whether the camera goes with the robot. */
  setFollows(on) {
    this.follows = on;
    if (on) this.viewpoint.follow(this.balance.mark.position);
    else this.viewpoint.follow(null);
    this.stage.invalidate();
  }

  /** What is between the camera and a body of the robot is made fainter. */
  fade() {
    if (!this.data.stances.length) return;
    const { camera } = this.stage;
    const ray = new Raycaster();
    const rays = this.robot.solid.children.map(({ position }) => position.clone().sub(camera.position));
    for (const layer of [this.obstacles, this.unseen, this.behind]) {
      const meshes = layer.visible ? layer.children.filter((part) => part.isMesh) : [];
      layer.fade?.(rays.some((towards) => {
        ray.set(camera.position, towards.clone().normalize());
        ray.far = towards.length();
        return ray.intersectObjects(meshes).length > 0;
      }));
    }
  }

  /** What is under a place of the window: the point in W and the face's id, or the level plane of a height. */
  under({ clientX, clientY }, height) {
    const box = this.stage.renderer.domElement.getBoundingClientRect();
    const place = new Vector2(2 * (clientX - box.left) / box.width - 1, 1 - 2 * (clientY - box.top) / box.height);
    const ray = new Raycaster();
    ray.setFromCamera(place, this.stage.camera);
    const faces = [...this.surfaces.parts.values()].map(({ face }) => face);
    const [hit] = ray.intersectObjects(faces);
    if (hit) return { point: hit.point, id: hit.object.userData.id };
    const point = ray.ray.intersectPlane(new Plane(new Vector3(0, 0, 1), -height), new Vector3());
    return point && { point, id: null };
  }

  draw() {
    this.stage.draw();
  }
}

/** In the place of the picture where the browser draws none: the tables say the rest. */
export class NoPicture {
  constructor(error) {
    $('stage').append(el('p', { class: 'no-picture', role: 'alert' },
      'This browser draws no picture: WebGL 2 is not there or switched off. All numbers are in the tables.'));
    for (const id of ['layers-box', 'views', 'key-box', 'view']) $(id).hidden = true;
    console.info(`no picture: ${error.message}`);
    this.viewpoint = { go() {}, orbit() {}, zoom() {}, listeners: [] };
    this.missing = true;
  }

  point() {}
  show() {}
  showMoment() {}
  setFollows() {}
  draw() {}
}

export function pictureOf(data) {
  const canvas = document.createElement('canvas');
  return canvas.getContext('webgl2') ? new Picture(data) : new NoPicture(new Error('no WebGL 2'));
}
