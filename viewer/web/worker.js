// The program, for one command: its files are in memory, what it says on stderr is told line by line.
import { ConsoleStdout, Directory, File, OpenFile, PreopenDirectory, WASI } from '@bjorn3/browser_wasi_shim';

/** Puts a file under its path, and the folders on the way. */
function put(folder, path, bytes) {
  const [name, ...rest] = path.split('/');
  if (!rest.length) return folder.contents.set(name, new File(bytes));
  if (!(folder.contents.get(name) instanceof Directory)) folder.contents.set(name, new Directory(new Map()));
  return put(folder.contents.get(name), rest.join('/'), bytes);
}

/** All files of a folder with their paths. */
function* files(folder, before = '') {
  for (const [name, entry] of folder.contents) {
    if (entry instanceof Directory) yield* files(entry, `${before}${name}/`);
    else yield [before + name, entry.data];
  }
}

onmessage = ({ data: { program, args, input, given } }) => {
  const root = new PreopenDirectory('/', new Map());
  for (const [path, bytes] of given) put(root.dir, path, bytes);
  const out = [];
  const wasi = new WASI(['scandent', ...args], [], [
    new OpenFile(new File(new TextEncoder().encode(input))),
    new ConsoleStdout((bytes) => out.push(bytes)),
    ConsoleStdout.lineBuffered((line) => postMessage({ line })),
    root,
  ], { debug: false });
  let code = null;
  try {
    code = wasi.start(new WebAssembly.Instance(program, { wasi_snapshot_preview1: wasi.wasiImport }));
  } catch (error) {
    // A panic, or more memory than there is: the page says so, and nothing is kept.
    postMessage({ line: `error: the program stopped: ${error.message}` });
  }
  postMessage({ ended: { code, out, files: code === null ? given : [...files(root.dir)] } });
};
