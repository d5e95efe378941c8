// Bundles src/ into one module and one style sheet: node build.mjs <directory>
import { build } from "esbuild";

await build({
  entryPoints: [
    { in: "src/index.js", out: "scene_view" },
    { in: "src/panel/style.css", out: "scene_view" },
    { in: "src/controls/index.js", out: "controls" },
    { in: "src/controls/controls.css", out: "controls" },
    { in: "src/workbench/index.js", out: "workbench" },
    { in: "src/workbench/workbench.css", out: "workbench" },
  ],
  outdir: process.argv[2] ?? "../static",
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  legalComments: "inline",
  logLevel: "warning",
});
