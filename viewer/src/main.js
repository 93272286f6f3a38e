// The viewer: reads the data in the page, draws the picture and shows one stance, or one instant, at a time.
import { VIEWS } from './camera.js';
import { describeChange, readData } from './data.js';
import { el } from './dom.js';
import { Editor } from './editor.js';
import { listenToKeys } from './keys.js';
import { Motion, describePhase } from './motion.js';
import { Panel } from './panel.js';
import { pictureOf } from './picture.js';
import { isDark, onTheme, startTheme, toggleTheme } from './theme.js';
import { Transport } from './transport.js';

const $ = (id) => document.getElementById(id);
/** `#stance=5&view=top&theme=dark`, `#time=12.5` for a moment of the motion, `#play=1` to play it */
const address = () => new URLSearchParams(location.hash.slice(1));
/** The tables follow the motion this often at most, ms. */
const TABLES_MS = 150;

function start() {
  const data = readData($('scandent-data'));
  startTheme(address().get('theme'));
  const picture = pictureOf(data);
  const { viewpoint } = picture;

  $('scene-name').textContent = data.scene;
  const things = data.kind === 'robot' ? 'contact patches' : 'surfaces';
  const weight = data.robot.name ? `${data.robot.name}, ${data.robot.mass_kg.toFixed(1)} kg · ` : '';
  $('scene-facts').textContent = `${weight}${data.surfaces.length} ${things}`;
  const { unsolved } = data.search;
  if (unsolved) {
    document.body.classList.add('unsolved');
    $('stage').append(el('div', { class: 'verdict', role: 'alert' }, el('b', {}, 'No plan'), unsolved.sentence));
  }
  $('theme').addEventListener('click', toggleTheme);
  onTheme(() => { $('theme').textContent = isDark() ? 'Light theme' : 'Dark theme'; });
  const views = VIEWS.map(({ name, label }, i) =>
    el('button', { type: 'button', id: `view-${name}`, title: `${label} (${i + 1})`, onclick: () => viewpoint.go(name) }, label));
  $('views').append(...views);
  viewpoint.listeners.push((name) => {
    for (const button of views) button.setAttribute('aria-pressed', String(button.id === `view-${name}`));
  });

  const transport = data.kind === 'surfaces' ? edit(data, picture) : play(data, picture);
  listenToKeys({ transport, viewpoint, toggleTheme });
  const follow = () => {
    viewpoint.go(address().get('view'));
    const time = address().get('time');
    if (transport.motion && time !== null) transport.seek(Number(time) || 0);
    else if (data.stances.length) transport.set(Number(address().get('stance')) || 0);
    if (address().get('play') && transport.motion) transport.toggle();
    picture.draw();
  };
  addEventListener('hashchange', follow);
  follow();
  return {
    stanceCount: data.stances.length,
    setStance: (index) => {
      transport.set(index);
      picture.draw();
    },
    seek: (time) => transport.motion && transport.seek(time),
    picture: !picture.missing,
    ready: true,
  };
}

/** The panel of an editor; nothing to play. */
function edit(data, picture) {
  new Editor($('panel'), data, picture);
  $('transport').hidden = true;
  return { count: 0 };
}

/** Panel and transport of a plan or a robot. */
function play(data, picture) {
  const panel = new Panel($('panel'), data, (id) => picture.point(id));
  const motion = data.motion ? new Motion(data.motion) : null;
  const showStance = (index) => {
    const stance = data.stances[index];
    picture.show(stance, data.stances[index - 1]);
    panel.show(stance);
    $('caption').replaceChildren(el('b', {}, `Stance ${index}`), describeChange(stance.change));
  };
  let told = -Infinity;
  const showTime = (time, phase, running) => {
    const moment = motion.moment(time, data.stances);
    picture.showMoment(moment, motion.at(time), data.stances[phase.to].support_level_m);
    if (!running || performance.now() - told > TABLES_MS) {
      told = performance.now();
      panel.showMoment(moment);
    }
    const seconds = `${time.toFixed(1)} s of ${motion.duration.toFixed(1)} s`;
    $('caption').replaceChildren(el('b', {}, seconds), `to stance ${phase.to}: ${describePhase(phase)}`);
  };
  const transport = new Transport($('transport'), data.stances, motion, showStance, showTime, (on) => picture.setFollows(on));
  if (data.stances.length < 2) $('transport').hidden = true;
  return transport;
}

function fail(error) {
  document.body.prepend(el('p', { class: 'failure', role: 'alert' }, `This page could not be drawn: ${error.message}`));
  console.error(error);
}

try {
  window.scandent = start();
} catch (error) {
  fail(error);
}
