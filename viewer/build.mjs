// Bundles the program of lessons: `node build.mjs OUTPUT`.
import { build } from "esbuild";
import { fileURLToPath } from "node:url";

await build({
  entryPoints: [fileURLToPath(new URL("src/main.ts", import.meta.url))],
  outfile: process.argv[2] ?? "../build/viewer/lesson.js",
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "utf8",
  loader: { ".css": "text", ".glsl": "text" },
  legalComments: "eof", // the notices that the licenses of the libraries ask for
  logLevel: "warning",
});
