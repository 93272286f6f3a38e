// The page around the pages: `scandent serve` without a server. The program runs in a worker, one for each request,
// on files that are in this page alone; a worker that is ended leaves them as they were.
import { el } from '../src/dom.js';

const $ = (id) => document.getElementById(id);
/** Bytes by path. */
const files = new Map();
/** The worker of the page that is awaited. */
let showing = null;
/** The worker of the plan that is computed, and how far it is, as `serve` tells it. */
let planning = null;
let status = { state: 'idle' };

const program = (async () => {
  const bytes = Uint8Array.from(atob($('program').textContent), (c) => c.charCodeAt(0));
  const whole = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return WebAssembly.compile(await new Response(whole).arrayBuffer());
})();

/** Runs one command; `line` hears what it says on stderr. */
async function run(args, { input = '', line = () => {}, began = () => {} } = {}) {
  const compiled = await program;
  const said = [];
  const given = [...files];
  return new Promise((done, fail) => {
    const url = URL.createObjectURL(new Blob([WORKER], { type: 'text/javascript' }));
    const worker = new Worker(url);
    const end = () => {
      worker.terminate();
      URL.revokeObjectURL(url);
    };
    worker.onerror = ({ message }) => { end(); fail(new Error(message)); };
    worker.onmessage = async ({ data }) => {
      if (data.line !== undefined) {
        if (!line(data.line)) said.push(data.line);
        return;
      }
      end();
      const { code, out, files: left } = data.ended;
      const after = new Map(left);
      for (const [path] of given) if (!after.has(path)) files.delete(path);
      for (const [path, bytes] of after) files.set(path, bytes);
      list();
      done({ code, text: await new Blob(out).text(), said: said.join('\n') });
    };
    began({ end: () => { end(); done({ code: null, text: '', said: '' }); } });
    worker.postMessage({ program: compiled, args, input, given });
  });
}

/** What went wrong, as the program says it. */
const why = (said) => said.replace(/^error: /m, '') || 'the program stopped';

/** One request, as `serve` answers it. */
async function request(method, path, body = '', hearing = {}) {
  const { code, text, said } = await run(['serve', '.'], { input: `${method} ${path}\n${body}`, ...hearing });
  if (code !== 0) throw new Error(why(said));
  return text;
}

/** What the pages ask: the same as of a server. */
async function ask(path, { method = 'GET', body = '' } = {}) {
  if (path === 'cancel' && planning) {
    status = { ...status, state: 'undecided', text: 'cancelled: nothing of it is kept' };
    planning.end();
  }
  if (path !== 'plan') return status;
  if (planning) throw new Error('a plan is being computed: cancel it, or wait');
  return new Promise((begun, fail) => {
    const began = (worker) => { planning = worker; };
    const line = (text) => {
      if (!text.startsWith('{')) return false;
      status = JSON.parse(text);
      begun(status);
      return true;
    };
    status = { state: 'running', stage: 'starting' };
    const stopped = (error) => {
      if (status.state === 'running') status = { ...status, state: 'error', text: error.message };
      fail(error);
    };
    request(method, path, body, { began, line }).catch(stopped).finally(() => { planning = null; });
  });
}

/** Where files can be added, as the page begins. */
const HINT = $('said').textContent;

/** Shows a page of the program. */
async function go(address) {
  const [path, hash = ''] = address.split('#');
  showing?.end();
  let mine = null;
  const began = (worker) => { mine = showing = worker; };
  try {
    say('…');
    const html = await request('GET', path, '', { began });
    if (mine !== showing) return;
    say(path ? '' : HINT);
    const frame = $('shown');
    frame.onload = () => {
      frame.contentWindow.location.hash = hash;
      taking(frame.contentDocument);
      frame.contentDocument.addEventListener('click', (event) => {
        const link = event.target.closest?.('a[href]')?.getAttribute('href');
        if (!link || /^(blob|data|https?|#)/.test(link)) return;
        event.preventDefault();
        go(link);
      });
      frame.contentDocument.addEventListener('submit', (event) => {
        event.preventDefault();
        go(`${event.target.getAttribute('action')}?${new URLSearchParams(new FormData(event.target))}`);
      });
    };
    frame.srcdoc = html;
  } catch (error) {
    if (mine === showing) say(error.message, true);
  }
}

function say(text, bad = false) {
  $('said').textContent = text;
  $('said').classList.toggle('bad', bad);
}

/** The files, to take away. */
function list() {
  $('files').replaceChildren(...[...files.keys()].sort().map((path) => el('a', {
    href: '#',
    onclick: (event) => {
      event.preventDefault();
      const url = URL.createObjectURL(new Blob([files.get(path)]));
      el('a', { href: url, download: path.replace(/^.*\//, '') }).click();
      setTimeout(() => URL.revokeObjectURL(url), 10_000);
    },
  }, path)));
}

async function add(given) {
  try {
    for (const [path, file] of given) files.set(path.replace(/^\/+/, ''), new Uint8Array(await file.arrayBuffer()));
    list();
    await go('');
  } catch (error) {
    say(error.message, true);
  }
}

/** The files of what was dropped, of folders all that is in them. */
async function* dropped(entry) {
  if (entry.isFile) yield [entry.fullPath, await new Promise((done, fail) => { entry.file(done, fail); })];
  if (!entry.isDirectory) return;
  const reader = entry.createReader();
  for (;;) {
    const some = await new Promise((done, fail) => { reader.readEntries(done, fail); });
    if (!some.length) return;
    for (const inside of some) yield* dropped(inside);
  }
}

function taking(part) {
  part.addEventListener('dragover', (event) => event.preventDefault());
  part.addEventListener('drop', async (event) => {
    event.preventDefault();
    const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry()).filter(Boolean);
    const given = [];
    for (const entry of entries) for await (const file of dropped(entry)) given.push(file);
    await add(given);
  });
}

for (const id of ['add-files', 'add-folder']) {
  $(id).addEventListener('change', ({ target }) => add([...target.files].map((file) => [file.webkitRelativePath || file.name, file])));
}
$('home').addEventListener('click', () => go(''));
taking(document);
window.scandentHost = { ask, go, run, add, files: () => files };
go('');
