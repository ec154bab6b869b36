// Bundles each widget's sources into one minified file that is committed, so that students need neither node nor a
// network. The first line holds a hash of the sources, which a quick test compares with the sources.
import { createHash } from "node:crypto";
import { copyFileSync, mkdirSync, readdirSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { build } from "esbuild";

const WIDGETS = [{ folder: "world", file: "../nao_course/widgets/world/static/world.js", licences: ["three"] }];

// Names and contents of the sources and of the lock file, in the order of their names; tests/widgets/test_bundles.py does the same.
function fingerprint(folder) {
  const hash = createHash("sha256");
  const names = readdirSync(folder).sort().map((name) => `${folder}/${name}`);
  for (const name of [...names, "bundle.mjs", "package-lock.json"]) {
    hash.update(`${name}\n`).update(readFileSync(name, "utf8").replaceAll("\r\n", "\n")).update("\n");
  }
  return hash.digest("hex");
}

for (const { folder, file, licences } of WIDGETS) {
  mkdirSync(dirname(file), { recursive: true });
  await build({
    entryPoints: [`${folder}/index.js`],
    outfile: file,
    bundle: true,
    minify: true,
    format: "esm",
    target: "es2022",
    charset: "utf8",
    legalComments: "none",
    loader: { ".css": "text" },
    banner: { js: `// Made by "make bundles" from web/${folder}; sources ${fingerprint(folder)}` },
  });
  for (const name of licences) copyFileSync(`node_modules/${name}/LICENSE`, join(dirname(file), `LICENSE-${name}.txt`));
}
