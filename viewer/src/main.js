// The plan viewer: reads the data in the page, builds the layers and shows one stance at a time.
import { Group } from 'three';
import { BalanceLayer } from './balance.js';
import { VIEWS, Viewpoint } from './camera.js';
import { cloudLayer, heightRange } from './cloud.js';
import { ContactsLayer } from './contacts.js';
import { describeChange, readData } from './data.js';
import { el } from './dom.js';
import { extentOf } from './extent.js';
import { goalLayer } from './goal.js';
import { listenToKeys } from './keys.js';
import { colourKey, layerSwitches } from './layers.js';
import { obstaclesLayer } from './obstacles.js';
import { Motion, describePhase } from './motion.js';
import { Panel } from './panel.js';
import { RobotLayer } from './robot.js';
import { routeLayer } from './route.js';
import { Stage } from './stage.js';
import { SurfacesLayer } from './surfaces.js';
import { isDark, onTheme, startTheme, toggleTheme } from './theme.js';
import { Transport } from './transport.js';

/** A stage narrower than this starts with its box of layers closed. */
const ROOMY_PX = 800;

const $ = (id) => document.getElementById(id);
/** `#stance=5&view=top&theme=dark`, or `#time=12.5` for a moment of the motion */
const address = () => new URLSearchParams(location.hash.slice(1));

function start() {
  const data = readData($('scandent-data'));
  startTheme(address().get('theme'));
  const robot = new RobotLayer(data.robot);
  const extent = extentOf(data, robot.boxes());
  const stage = new Stage($('stage'), $('view'), $('labels'), extent);
  const viewpoint = new Viewpoint(stage, extent.points, extent.heading);

  // The layers.
  const range = data.cloud ? heightRange(data.cloud.positions) : null;
  const cloud = data.cloud ? cloudLayer(data.cloud.positions, range) : new Group();
  const surfaces = new SurfacesLayer(stage, data.surfaces);
  const obstacles = obstaclesLayer(data.obstacles);
  const ghost = new Group().add(robot.ghost);
  const contacts = new ContactsLayer(stage, data);
  const balance = new BalanceLayer(stage, data.stances);
  const goal = goalLayer(stage, data.goal, extent.floor, data.stances.at(-1)?.poses[2] ?? extent.floor);
  const route = routeLayer(stage, data.search.route ?? []);
  stage.scene.add(route, cloud, surfaces.fill, surfaces.inset, surfaces.frames, surfaces.names, obstacles, robot.solid,
    ghost, contacts.patches, contacts.forces, contacts.places, balance.group, balance.path, goal);

  // The page around them.
  $('scene-name').textContent = data.scene;
  $('scene-facts').textContent = `${data.robot.name}, ${data.robot.mass_kg.toFixed(1)} kg · ${data.surfaces.length} surfaces`;
  const { unsolved } = data.search;
  if (unsolved) {
    document.body.classList.add('unsolved');
    $('stage').append(el('div', { class: 'verdict', role: 'alert' }, el('b', {}, 'No plan'), unsolved.sentence));
  }
  layerSwitches($('layers'), [
    ['cloud', 'Scan', cloud, data.cloud !== null],
    ['surface', 'Surfaces', surfaces.fill, true],
    ['inset', 'Inset polygons', surfaces.inset, true],
    ['frames', 'Frames', surfaces.frames, true],
    ['names', 'Names', surfaces.names, true],
    ['obstacle', 'Obstacles', obstacles, data.obstacles.length > 0],
    ['robot', 'Robot', robot.solid, true],
    ['ghost', 'Previous stance', ghost, true],
    ['contact', 'Contacts', contacts.patches, true],
    ['force', 'Forces', contacts.forces, true],
    ['support', 'CoM and support', balance.group, true],
    ['place', 'All footholds', contacts.places, true],
    ['path', 'CoM path', balance.path, true, false],
    ['route', 'Route of the base', route, route.children.length > 0],
    ['goal', 'Goal', goal, true],
  ], () => stage.invalidate());
  colourKey($('key'), { cloud: data.cloud, range, scale: contacts.scale, surfaces: data.surfaces });
  const box = $('layers-box');
  box.open = stage.width > ROOMY_PX;
  const reserve = () => stage.reserve(box.open && stage.width > ROOMY_PX ? box.offsetWidth : 0);
  box.addEventListener('toggle', reserve);
  reserve();
  const panel = new Panel($('panel'), data, (id) => {
    surfaces.point(id);
    stage.invalidate();
  });
  $('theme').addEventListener('click', toggleTheme);
  onTheme(() => { $('theme').textContent = isDark() ? 'Light theme' : 'Dark theme'; });
  const views = VIEWS.map(({ name, label }, i) =>
    el('button', { type: 'button', id: `view-${name}`, title: `${label} (${i + 1})`, onclick: () => viewpoint.go(name) }, label));
  $('views').append(...views);
  viewpoint.listeners.push((name) => {
    for (const button of views) button.setAttribute('aria-pressed', String(button.id === `view-${name}`));
  });

  // One stance at a time.
  const motion = data.motion ? new Motion(data.motion) : null;
  const showStance = (index) => {
    const stance = data.stances[index];
    const before = data.stances[index - 1];
    RobotLayer.pose(robot.solid, stance.poses);
    robot.ghost.visible = before !== undefined;
    if (before) RobotLayer.pose(robot.ghost, before.poses);
    surfaces.setUsed(stance.contacts.map((contact) => contact.face));
    contacts.show(stance);
    balance.show(stance);
    panel.show(stance);
    $('caption').replaceChildren(el('b', {}, `Stance ${index}`), describeChange(stance.change));
    stage.invalidate();
  };
  // Between stances the robot moves; what is said is of the stance that it comes to.
  const showTime = (time, phase) => {
    RobotLayer.pose(robot.solid, motion.at(time));
    robot.ghost.visible = false;
    const seconds = `${time.toFixed(1)} s of ${motion.duration.toFixed(1)} s`;
    $('caption').replaceChildren(el('b', {}, seconds), `to stance ${phase.to}: ${describePhase(phase)}`);
    stage.invalidate();
  };
  const transport = new Transport($('transport'), data.stances, motion, showStance, showTime);
  listenToKeys({ transport, viewpoint, canvas: $('view'), toggleTheme });

  const follow = () => {
    viewpoint.go(address().get('view'));
    const time = address().get('time');
    if (motion && time !== null) transport.seek(Number(time) || 0);
    else if (data.stances.length) transport.set(Number(address().get('stance')) || 0);
    else for (const part of [robot.solid, ghost, balance.group]) part.visible = false;
    stage.draw();
  };
  addEventListener('hashchange', follow);
  follow();
  return {
    stanceCount: data.stances.length,
    setStance: (index) => {
      transport.set(index);
      stage.draw();
    },
    ready: true,
  };
}

function fail(error) {
  document.body.prepend(el('p', { class: 'failure', role: 'alert' }, `This page could not draw the plan: ${error.message}`));
  console.error(error);
}

try {
  window.scandent = start();
} catch (error) {
  fail(error);
}
