// How fast a lesson is drawn in Chromium by the processor: `node lesson_speed.mjs LESSON`, prints JSON.
// Wall time depends on what else the machine does; the processor time of Chromium's processes hardly does.
import { readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const require = createRequire(new URL("../viewer/package.json", import.meta.url));
const { chromium } = require("playwright-core");
const TICK = 10; // milliseconds in the unit of /proc/*/stat

/** Processor time in ms of all processes below this one. */
function spent() {
  const all = new Map();
  for (const id of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const text = readFileSync(`/proc/${id}/stat`, "utf8");
      const fields = text.slice(text.lastIndexOf(")") + 2).split(" ");
      all.set(Number(id), { parent: Number(fields[1]), time: TICK * (Number(fields[11]) + Number(fields[12])) });
    } catch {
      // it has ended meanwhile
    }
  }
  let sum = 0;
  for (const [id, { time }] of all) {
    let above = id;
    while (above > 1 && above !== process.pid) above = all.get(above)?.parent ?? 0;
    if (above === process.pid && id !== process.pid) sum += time;
  }
  return sum;
}

const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
const told = {};
try {
  const context = await browser.newContext({ offline: true, viewport: { width: 1000, height: 560 } });
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  await page.goto("about:blank");

  const measured = async (name, pictures, draw) => {
    const [begin, before] = [performance.now(), spent()];
    await page.evaluate(draw, pictures);
    const wall = performance.now() - begin;
    told[name] = { pictures, wall_ms: wall / pictures, processor_ms: (spent() - before) / pictures };
  };

  // The yardstick: as many triangles and pixels as a plain lesson has, one light, nothing that moves but the camera.
  await page.evaluate(() => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 356, height: 180 });
    document.body.append(canvas);
    const gl = canvas.getContext("webgl2", { antialias: false });
    const shader = (type, text) => {
      const made = gl.createShader(type);
      gl.shaderSource(made, text);
      gl.compileShader(made);
      return made;
    };
    const program = gl.createProgram();
    gl.attachShader(program, shader(gl.VERTEX_SHADER, `#version 300 es
      in vec2 p; uniform float t; out vec3 n;
      void main() { float h = 0.2 * sin(9.0 * p.x + t); n = normalize(vec3(-1.8 * cos(9.0 * p.x + t), 0.0, 1.0));
        gl_Position = vec4(p.x, p.y + h, 0.5 * h, 1.0); }`));
    gl.attachShader(program, shader(gl.FRAGMENT_SHADER, `#version 300 es
      precision highp float; in vec3 n; out vec4 c;
      void main() { c = vec4(vec3(0.8, 0.6, 0.5) * max(0.0, dot(normalize(n), vec3(0.6, 0.0, 0.8))), 1.0); }`));
    gl.linkProgram(program);
    gl.useProgram(program);
    const across = 143;
    const place = [];
    const index = [];
    for (let y = 0; y <= across; y++) for (let x = 0; x <= across; x++) place.push((1.8 * x) / across - 0.9, (1.2 * y) / across - 0.6);
    for (let y = 0; y < across; y++) {
      for (let x = 0; x < across; x++) {
        const a = y * (across + 1) + x;
        index.push(a, a + 1, a + across + 1, a + 1, a + across + 2, a + across + 1);
      }
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(place), gl.STATIC_DRAW);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(index), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(gl.getAttribLocation(program, "p"), 2, gl.FLOAT, false, 0, 0);
    gl.enable(gl.DEPTH_TEST);
    const time = gl.getUniformLocation(program, "t");
    window.draw = (n) => {
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniform1f(time, 0.05 * n);
      gl.drawElements(gl.TRIANGLES, index.length, gl.UNSIGNED_INT, 0);
    };
  });
  const pictures = (count) => new Promise((then) => {
    let left = count;
    const next = () => {
      if (!left--) return then(null);
      window.draw(left);
      requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
  });
  await page.evaluate(pictures, 10);
  await measured("yardstick", 20, pictures);

  // The first picture: from the start of the page until the task behind the one that drew it.
  await page.addInitScript(() => {
    const prototype = WebGL2RenderingContext.prototype;
    const draw = prototype.drawElements;
    prototype.drawElements = function (...given) {
      prototype.drawElements = draw;
      const behind = new MessageChannel();
      behind.port1.onmessage = () => (window.firstPicture = performance.now());
      behind.port2.postMessage(null);
      return draw.apply(this, given);
    };
  });
  await page.goto(pathToFileURL(process.argv[2]).href);
  await page.waitForFunction(() => window.lappetLesson && window.firstPicture);
  told.first_picture_ms = await page.evaluate(() => window.firstPicture);
  await page.waitForTimeout(1500); // it rests, and is drawn with all its pixels
  await page.evaluate(() => {
    const canvas = document.querySelector("canvas");
    window.turn = (n) => canvas.dispatchEvent(new KeyboardEvent("keydown", { key: n % 40 < 20 ? "ArrowLeft" : "ArrowRight", bubbles: true }));
    // A whole frame on in every picture: more than playing asks for, which takes several pictures for a frame.
    window.step = () => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: ".", bubbles: true }));
    window.draw = window.turn;
  });
  await page.evaluate(pictures, 25); // the picture becomes as coarse as it needs
  await measured("turning", 20, pictures);
  await page.evaluate(() => {
    lappetLesson.seek(0);
    window.draw = window.step;
  });
  await measured("stepping", 20, pictures);
  // As it is played: pictures that are drawn in three seconds, between two frames too.
  told.played = await page.evaluate(async () => {
    lappetLesson.seek(0);
    const space = () => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: " ", bubbles: true }));
    space();
    await new Promise((then) => setTimeout(then, 1000));
    const ask = window.requestAnimationFrame;
    let pictures = 0;
    window.requestAnimationFrame = (then) => ask((time) => (pictures++, then(time)));
    const begin = performance.now();
    await new Promise((then) => setTimeout(then, 3000));
    const second = (1000 * pictures) / (performance.now() - begin);
    window.requestAnimationFrame = ask;
    space();
    return { pictures_a_second: second };
  });
} finally {
  await browser.close();
}
console.log(JSON.stringify(told));
