// Asking the server that gave this page for a plan.
import { el } from './dom.js';

const EVERY_MS = 400;
const ENDED = {
  verified: 'A plan was found and verified.',
  no_plan: 'There is no plan.',
  undecided: 'No plan was found, and none is excluded.',
  error: 'This cannot be planned.',
};

/** The page around this one, where the program is in that page and no server is asked. */
const host = (() => {
  try {
    return parent.scandentHost;
  } catch {
    return undefined;
  }
})();

/** The token is the first part of the address. */
const at = (path) => (host ? path : `/${location.pathname.split('/')[1]}/${path}`);

async function ask(path, options) {
  if (host) return host.ask(path, options);
  const answer = await fetch(at(path), options);
  const said = await answer.json();
  if (!answer.ok) throw new Error(said.error ?? `the server answers ${answer.status}`);
  return said;
}

/** Buttons and progress; `files` gives the scene and the surfaces, or throws what is missing. */
export function planner(files) {
  const plan = el('button', { type: 'button', id: 'plan', class: 'main', onclick: () => start() }, 'Plan');
  const cancel = el('button', { type: 'button', id: 'cancel', disabled: true, onclick: () => stop() }, 'Cancel');
  const state = el('output', { id: 'state', 'aria-live': 'polite' });
  const bar = el('progress', { 'aria-label': 'planning', hidden: true });
  const details = el('pre', { id: 'details', hidden: true });
  const say = (text, bad = false) => {
    state.replaceChildren(text);
    state.classList.toggle('bad', bad);
  };
  const busy = (on) => {
    plan.disabled = on;
    cancel.disabled = !on;
    bar.hidden = !on;
  };
  async function start() {
    try {
      const { scene, surfaces } = files();
      busy(true);
      details.hidden = true;
      say('asked');
      const { command } = await ask('plan', { method: 'POST', body: JSON.stringify({ scene, surfaces }) });
      details.textContent = command;
      details.hidden = false;
      await watch();
    } catch (error) {
      busy(false);
      say(error.message, true);
    }
  }
  async function stop() {
    say('stopping');
    await ask('cancel', { method: 'POST' }).catch((error) => say(error.message, true));
  }
  async function watch() {
    for (;;) {
      const now = await ask('status');
      const { stage, nodes, to_go_m: toGo, seconds = 0 } = now;
      if (now.state !== 'running') return ended(now);
      const far = typeof toGo === 'number' ? `, ${toGo.toFixed(2)} m to go` : '';
      say(`${stage}: ${nodes === undefined ? '' : `${nodes} contact sets${far}, `}${seconds.toFixed(0)} s`);
      await new Promise((later) => { setTimeout(later, EVERY_MS); });
    }
  }
  function ended({ state: how, text, page }) {
    busy(false);
    details.textContent = `${details.textContent}\n\n${text}`;
    details.hidden = false;
    say(ENDED[how] ?? how, how !== 'verified');
    if (!page) return;
    const shown = `${at(page)}${how === 'verified' ? '#play=1' : ''}`;
    state.append(' ', el('a', { id: 'result', href: shown }, how === 'verified' ? 'Show it' : 'Show how far it came'));
    if (how === 'verified') (host?.go ?? ((address) => location.assign(address)))(shown);
  }
  return el('fieldset', {}, el('legend', {}, 'Plan'), el('div', { class: 'row' }, plan, cancel), bar, state, details);
}
