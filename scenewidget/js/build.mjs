// Bundles src/ into one module and one style sheet: node build.mjs <directory>
import { build } from "esbuild";

await build({
  entryPoints: { scene_view: "src/index.js" },
  outdir: process.argv[2] ?? "../static",
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  legalComments: "inline",
  logLevel: "warning",
});
