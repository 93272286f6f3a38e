// The contact schedule: a row for each patch, a column for each stance.
import { el } from './dom.js';

/** Patches in the order in which the plan names them. */
export function patchNames(stances) {
  return [...new Set(stances.flatMap((stance) => stance.contacts.map((contact) => contact.patch)))];
}

/** Runs of stances in which a patch keeps one place: first, end, surface and the load in each. */
function runs(stances, patch) {
  const found = [];
  stances.forEach((stance, i) => {
    const contact = stance.contacts.find((c) => c.patch === patch);
    if (!contact) return;
    const run = found.at(-1);
    const place = String(contact.vertices_W);
    if (run && run.end === i && run.place === place) {
      run.end = i + 1;
      run.loads.push(contact.loaded);
    } else {
      found.push({ first: i, end: i + 1, place, face: contact.face, loads: [contact.loaded] });
    }
  });
  return found;
}

/** The rows, to stand above a slider of the same columns; `go` is called with a stance. */
export function schedule(stances, go) {
  const rows = patchNames(stances).map((patch) => {
    const lane = el('div', { class: 'lane' });
    lane.style.gridTemplateColumns = `repeat(${stances.length}, minmax(0, 1fr))`;
    for (const run of runs(stances, patch)) {
      const block = el('div', { class: 'run' },
        run.loads.map((loaded) => el('i', { class: loaded ? 'loaded' : 'unloaded' })),
        el('span', {}, run.face));
      block.style.gridColumn = `${run.first + 1} / ${run.end + 1}`;
      block.title = `${patch} on ${run.face}, stances ${run.first} to ${run.end - 1}`;
      lane.append(block);
    }
    lane.addEventListener('click', (event) => {
      const box = lane.getBoundingClientRect();
      const column = Math.floor((stances.length * (event.clientX - box.left)) / box.width);
      go(Math.min(Math.max(column, 0), stances.length - 1));
    });
    return [el('span', { class: 'lane-name' }, patch), lane];
  });
  return rows.flat();
}
