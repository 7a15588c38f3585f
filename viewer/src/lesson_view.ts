// The whole lesson on the page: picture, caption, time bar and options, and what ties them together.
import type { Arrays } from "./arrays";
import type { View } from "./camera";
import { iconButton, make, name } from "./elements";
import { listenToKeys } from "./keyboard";
import { Legend } from "./legend";
import type { Chapter, Lesson, Vector } from "./lesson";
import { Options, type Theme } from "./options";
import { Picture } from "./picture";
import { Player } from "./player";
import { PrintSheet } from "./print_sheet";
import { drawsInSoftware } from "./software";
import { type Shown, Stage } from "./stage";
import { Timeline } from "./timeline";
import { Transport } from "./transport";
import type { Words } from "./words";

/** What a lesson of several procedures puts around the picture of a chapter, and is told. */
export interface Surroundings {
  bar: HTMLElement; // below the title
  panel: HTMLElement | null; // beside the picture
  chapter: Chapter;
  optionsOpen: boolean;
  painted(time: number, playing: boolean): void;
  spoken(): void;
}

const NARROW = "(max-width: 899px)";

export class LessonView {
  readonly element = make("div", { id: "app" });
  readonly stages: Stage[];
  readonly player: Player;
  readonly shown: Shown;
  readonly canvas = make("canvas", { tabindex: 0, role: "application" });
  private readonly overlay = make("div", { id: "labels", "aria-hidden": "true" });
  private readonly caption = make("p", { id: "caption", role: "status", "aria-live": "polite" });
  readonly transport: Transport;
  private readonly options: Options;
  private readonly legend: Legend;
  private readonly fullscreen: HTMLButtonElement;
  private readonly open: HTMLButtonElement;
  private readonly ended = new AbortController();
  picture!: Picture;
  private told = "";
  private asked = 0;
  private before = 0;

  constructor(
    private readonly lesson: Lesson,
    private readonly words: Words,
    arrays: Arrays,
    private readonly around: Surroundings | null = null,
  ) {
    const shadowPixels = drawsInSoftware() ? 1024 : 2048;
    this.stages = lesson.procedures.map((procedure) => new Stage(lesson, procedure, arrays, shadowPixels));
    const labeled = (kind: string): boolean =>
      lesson.procedures.some((each) => each.labels.some((label) => label.kind === kind));
    const has = (strand: string): boolean => lesson.procedures.some((each) => each.strands[strand]?.lines.some(Boolean));
    this.shown = {
      look: "grid",
      hooks: true,
      threads: true,
      marks: true,
      letters: true,
      landmarks: false,
      around: true,
      vessels: false,
    };
    const look = around?.chapter.look as Shown["look"] | undefined;
    if (look) this.shown.look = look;
    const timeline = new Timeline(lesson.procedures);
    this.player = new Player(timeline, () => this.draw());
    this.transport = new Transport(this.player, words);
    const available = (["hooks", "threads", "marks"] as const).filter(has);
    this.options = new Options(
      lesson,
      words,
      this.shown,
      [
        ...available,
        ...(labeled("corner") ? (["letters"] as const) : []),
        ...(labeled("landmark") ? (["landmarks"] as const) : []),
        ...(this.stages.some((stage) => stage.hasBody) ? (["around"] as const) : []),
        ...(this.stages.some((stage) => stage.hasVessels) ? (["vessels"] as const) : []),
      ],
      {
        changed: () => this.draw(),
        view: (view) => this.show(view),
        language: (language) => this.speak(language),
        theme: (theme) => this.setTheme(theme),
        print: () => window.print(),
        close: () => this.openOptions(false),
      },
    );
    this.legend = new Legend(lesson, words);
    this.fullscreen = iconButton("fullscreen", () => this.toggleFullscreen(), { id: "fullscreen" });
    this.open = iconButton("options", () => this.openOptions(this.options.element.hidden), {
      id: "open-options",
      "aria-controls": "options",
    });
    this.build();
  }

  /** Begins to draw; the element must be on the page. */
  start(): void {
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.picture = new Picture(this.canvas, this.overlay, this.stages, this.player.timeline, still, () => this.draw());
    this.openOptions(this.around?.optionsOpen ?? !window.matchMedia(NARROW).matches, false);
    const { signal } = this.ended;
    listenToKeys(this.canvas, this.player, this.transport, this.picture, (view) => this.show(view), signal);
    const sheet = new PrintSheet(
      this.lesson, this.words, this.picture, this.player.timeline, this.transport, this.shown, () => this.draw(),
      signal, this.around?.chapter ?? null,
    );
    document.body.append(sheet.element);
    this.speak(this.words.language);
    const view = this.around?.chapter.view ?? "oblique";
    this.picture.show(view, true);
    this.options.showView(view);
    if (this.around) this.player.toStep(this.around.chapter.step);
  }

  /** Ends the view; its element can be taken away. */
  end(): void {
    this.ended.abort();
    cancelAnimationFrame(this.asked);
    this.asked = -1; // nothing is drawn any more
    this.picture.dispose();
  }

  /** Whether the panel of options is open. */
  get optionsOpen(): boolean {
    return !this.options.element.hidden;
  }

  /** Draws again soon, after `shown` was changed. */
  changed(): void {
    this.options.showShown();
    this.draw();
  }

  /** What scripts may ask and do, tests among them. */
  scripting(): object {
    return {
      procedures: this.stages.length,
      frames: (procedure = 0) => this.lesson.procedures[procedure].times,
      /** Draws a frame at once and returns the positions of the cache's vertices, x, y, z of each in mm. */
      positions: (frame: number, procedure = 0) => {
        this.stages[procedure].show(frame, this.shown);
        return Array.from(this.stages[procedure].points());
      },
      seek: (time: number) => {
        this.player.seek(time);
        this.paint(performance.now());
      },
      /** The positions that are on the screen. */
      shown: (procedure = 0) => Array.from(this.stages[procedure].points()),
      resting: () => !this.asked && !this.player.playing && this.picture.resting,
      /** Where a place in mm is on the page, in CSS pixels. */
      onScreen: (place: Vector, procedure = 0) => this.picture.onScreen(this.stages[procedure].placed(place), procedure),
      /** The camera in mm: its axes (right, up, backwards) and place, column by column, and its lens in degrees. */
      camera: (procedure = 0) => this.picture.seenFrom(this.stages[procedure]),
      time: () => this.player.time,
      length: () => this.player.timeline.length,
      epoch: (frame: number, procedure = 0) =>
        this.lesson.procedures[procedure].epochs.findIndex((each) => each.frames.includes(frame)),
    };
  }

  private build(): void {
    const titles = this.stages.length > 1 ? this.lesson.procedures.map((each) => make("h2", {}, each.title)) : [];
    const head = make(
      "header",
      {},
      make("h1", {}, this.lesson.title),
      make("div", { class: "buttons" }, this.fullscreen, this.open),
    );
    if (!document.fullscreenEnabled) this.fullscreen.hidden = true;
    const frame = make("div", { id: "picture" }, this.canvas, this.overlay);
    if (titles.length) frame.append(make("div", { class: "titles" }, ...titles));
    frame.append(this.legend.element);
    const main = make("main", {}, frame, this.caption, this.transport.element);
    this.element.append(head);
    if (this.around) {
      this.element.classList.add("course");
      this.element.classList.toggle("plain", !this.around.panel);
      this.element.append(this.around.bar, ...(this.around.panel ? [this.around.panel] : []));
    }
    this.element.append(main, this.options.element);
  }

  private show(view: View): void {
    this.picture.show(view);
    this.options.showView(view);
  }

  private speak(language: string): void {
    this.words.language = language;
    document.documentElement.lang = language;
    this.options.speak();
    this.transport.speak();
    this.legend.speak();
    name(this.open, this.words.say("options"));
    name(this.fullscreen, this.words.say("fullscreen"));
    this.told = "";
    this.around?.spoken();
    this.draw();
  }

  private setTheme(theme: Theme): void {
    if (theme === "auto") delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = theme;
  }

  private openOptions(open: boolean, focus = true): void {
    this.options.element.hidden = !open;
    this.element.classList.toggle("with-options", open);
    this.open.setAttribute("aria-expanded", String(open));
    if (!focus) return;
    if (open) this.options.element.querySelector<HTMLElement>("input, button")?.focus();
    else this.open.focus();
  }

  private toggleFullscreen(): void {
    if (document.fullscreenElement) void document.exitFullscreen();
    else void document.documentElement.requestFullscreen().catch(() => undefined);
  }

  private draw(): void {
    if (this.asked || !this.picture) return;
    this.asked = requestAnimationFrame((now) => {
      this.asked = 0;
      this.player.advance(Math.min(0.1, Math.max(0, (now - this.before) / 1000)));
      this.paint(now);
    });
  }

  private paint(now: number): void {
    const { player } = this;
    const moving = this.picture.draw(player.time, this.shown, player.playing);
    this.transport.update(player.time);
    this.legend.update(this.shown.look);
    this.options.showView(this.picture.currentView);
    this.tell();
    this.around?.painted(player.time, player.playing);
    this.before = now;
    if (moving || player.playing) this.draw();
  }

  /** Says which step is shown, where it is another than before. */
  private tell(): void {
    const { steps } = this.player.timeline;
    if (!steps.length) return;
    const step = this.player.step;
    const caption = this.transport.caption(step);
    const text = this.words.say("step", { number: step + 1, count: steps.length, caption });
    if (text === this.told) return;
    this.told = text;
    this.caption.replaceChildren(
      make("span", { class: "number", "aria-hidden": "true" }, String(step + 1)),
      make("span", { class: "spoken" }, text),
      make("span", { class: "seen", "aria-hidden": "true" }, caption),
    );
    this.canvas.setAttribute("aria-label", this.words.say("picture", { caption }));
  }
}
