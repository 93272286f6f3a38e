// Bundles src/ and three.js into dist/viewer.js, which is committed and embedded by src/view/, and web/ with its worker
// into dist/web.js, which `scripts/web-page` puts around the program.
// The banners name the sources' hash, so that a test notices a bundle older than its sources.
import { build } from 'esbuild';
import { createHash } from 'node:crypto';
import { copyFile, mkdir, readdir, readFile } from 'node:fs/promises';

const hash = createHash('sha256');
for (const folder of ['src', 'web']) {
  const sources = (await readdir(folder)).filter((name) => name.endsWith('.js')).sort();
  for (const name of sources) hash.update(await readFile(`${folder}/${name}`));
}
const sources = `sources sha256:${hash.digest('hex')}`;
const version = async (name) => JSON.parse(await readFile(`node_modules/${name}/package.json`, 'utf8')).version;
const bundled = (entry, more) => build({
  entryPoints: [entry],
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2022',
  charset: 'ascii',
  legalComments: 'inline',
  ...more,
});

await mkdir('dist', { recursive: true });
await bundled('src/main.js', {
  outfile: 'dist/viewer.js',
  banner: { js: `/* scandent viewer; ${sources}; contains three.js ${await version('three')} (MIT, see LICENSE.three) */` },
});
const worker = await bundled('web/worker.js', { write: false });
const shim = '@bjorn3/browser_wasi_shim';
await bundled('web/page.js', {
  outfile: 'dist/web.js',
  define: { WORKER: JSON.stringify(worker.outputFiles[0].text) },
  banner: { js: `/* scandent page; ${sources}; contains ${shim} ${await version(shim)} (MIT OR Apache-2.0) */` },
});
await copyFile('node_modules/three/LICENSE', 'dist/LICENSE.three');
await copyFile(`node_modules/${shim}/LICENSE-MIT`, 'dist/LICENSE.browser_wasi_shim');
