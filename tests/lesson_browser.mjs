// Opens lessons in Chromium without a network and does in each what a line of JSON says; answers with a line of JSON.
// A line has the lesson and its actions, a list of [name, value], see `does`. The lesson is a file, or a folder whose files
// answer as those of a site, http://lesson.test/, of which index.html is opened. All lessons are opened in one browser,
// each in a context of its own, which shares nothing with the others; it ends with the input.
import { existsSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { extname, join } from "node:path";
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

const require = createRequire(new URL("../viewer/package.json", import.meta.url));
const { chromium, devices } = require("playwright-core");

const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
async function opened({ lesson, actions, device, options }) {
  const told = { results: [], console: [], requests: [] };
  const context = await browser.newContext({ offline: true, ...(device ? devices[device] : {}), ...options });
  try {
    const page = await context.newPage();
    page.setDefaultTimeout(120_000);
    page.on("console", (message) => {
      if (["error", "warning"].includes(message.type())) told.console.push(message.text());
    });
    page.on("pageerror", (error) => told.console.push(String(error)));
    page.on("request", (request) => told.requests.push(request.url().slice(0, 60)));
    const kinds = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".json": "application/json" };
    await context.route("http://lesson.test/**", (route) => {
      const file = join(lesson, decodeURIComponent(new URL(route.request().url()).pathname));
      if (!existsSync(file) || statSync(file).isDirectory()) return route.fulfill({ status: 404, body: "" });
      const contentType = kinds[extname(file)] ?? "application/octet-stream";
      return route.fulfill({ body: readFileSync(file), contentType: `${contentType}; charset=utf-8` });
    });
    await page.goto(statSync(lesson).isDirectory() ? "http://lesson.test/index.html" : pathToFileURL(lesson).href);
    const does = {
      ready: () => page.waitForFunction(() => window.lappetLesson).then(() => true),
      text: (selector) => page.locator(selector).innerText(),
      attribute: ([selector, name]) => page.locator(selector).getAttribute(name),
      count: (selector) => page.locator(selector).count(),
      visible: (selector) => page.locator(selector).isVisible(),
      evaluate: (script) => page.evaluate(script),
      click: (selector) => page.locator(selector).click(),
      check: (selector) => page.locator(selector).check({ force: true }),
      uncheck: (selector) => page.locator(selector).uncheck(),
      select: ([selector, value]) => page.locator(selector).selectOption(value),
      // A click at a place of the tissue in mm, as long as it is not hidden there.
      clickPlace: async ([x, y, z]) => {
        const [left, top] = await page.evaluate((place) => window.lappetLesson.onScreen(place), [x, y, z]);
        await page.mouse.click(left, top);
      },
      press: (key) => page.keyboard.press(key),
      focus: (selector) => page.locator(selector).focus(),
      drag: async ([x, y, dx, dy]) => {
        await page.mouse.move(x, y);
        await page.mouse.down();
        await page.mouse.move(x + dx, y + dy, { steps: 4 });
        await page.mouse.up();
      },
      wait: (milliseconds) => page.waitForTimeout(milliseconds),
      // By asking again and again: the page's policy lets no predicate be made of a string in it.
      until: async (script) => {
        const end = Date.now() + 60_000;
        while (!(await page.evaluate(script))) {
          if (Date.now() > end) throw new Error(`never true: ${script}`);
          await page.waitForTimeout(100);
        }
        return true;
      },
      // What the picture looks like: share of its pixels that differ from those of the last call.
      changed: async () => {
        return page.evaluate(async () => {
          const frame = () => new Promise((then) => requestAnimationFrame(() => setTimeout(then, 60)));
          for (let quiet = 0; quiet < 3; quiet = window.lappetLesson.resting() ? quiet + 1 : 0) await frame();
          const canvas = document.querySelector("canvas");
          const copy = new OffscreenCanvas(160, 120);
          const pen = copy.getContext("2d");
          pen.drawImage(canvas, 0, 0, 160, 120);
          const now = pen.getImageData(0, 0, 160, 120).data;
          const before = window.lastPicture;
          window.lastPicture = now;
          if (!before) return 1;
          let different = 0;
          for (let i = 0; i < now.length; i += 4) {
            if (Math.abs(now[i] - before[i]) + Math.abs(now[i + 1] - before[i + 1]) + Math.abs(now[i + 2] - before[i + 2]) > 12)
              different++;
          }
          return different / (160 * 120);
        });
      },
      axe: async () => {
        await page.evaluate(readFileSync(require.resolve("axe-core/axe.min.js"), "utf8"));
        const found = await page.evaluate(() => axe.run(document, { resultTypes: ["violations"] }));
        return found.violations.map((each) => `${each.id}: ${each.nodes.map((node) => node.target).join(", ")}`);
      },
      save: (path) => page.screenshot({ path }).then(() => true),
      pdf: (path) => page.pdf({ path }).then(() => true),
      tree: () => page.locator("body").ariaSnapshot(),
      into: async ([script, path]) => writeFileSync(path, JSON.stringify(await page.evaluate(script))),
    };
    for (const [name, value] of actions) told.results.push((await does[name](value)) ?? null);
  } finally {
    await context.close();
  }
  return told;
}

for await (const line of createInterface({ input: process.stdin })) {
  const answer = await opened(JSON.parse(line)).catch((error) => ({ error: String(error.stack ?? error) }));
  console.log(JSON.stringify(answer));
}
await browser.close();
