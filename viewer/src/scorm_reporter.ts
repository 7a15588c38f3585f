// Reports to a learning platform by SCORM 1.2: its object `API` stands in a window around this one, or in its opener.
import type { Answer, Reporter } from "./reporter";
import type { Kept, Standing } from "./standing";

interface Api {
  LMSInitialize(none: ""): string | boolean;
  LMSFinish(none: ""): string | boolean;
  LMSGetValue(key: string): string;
  LMSSetValue(key: string, value: string): string | boolean;
  LMSCommit(none: ""): string | boolean;
}

const MOST_WINDOWS = 12;
const SOON = 800; // milliseconds in which reports are gathered before the platform keeps them
const DONE = ["completed", "passed", "failed"];

function apiOf(window: Window | null): Api | null {
  for (let k = 0; window && k < MOST_WINDOWS; k++) {
    try {
      const { API } = window as unknown as { API?: Api };
      if (API) return API;
      if (window.parent === window) return null;
      window = window.parent;
    } catch {
      return null; // a window of somebody else
    }
  }
  return null;
}

export class ScormReporter implements Reporter {
  private readonly began = Date.now();
  private interactions = 0;
  private soon = 0;
  private status = "";
  private over = false;

  private constructor(private readonly api: Api) {}

  static found(): ScormReporter | null {
    const api = apiOf(window) ?? apiOf(window.opener as Window | null);
    return api && new ScormReporter(api);
  }

  begin(): Promise<Kept | null> {
    this.api.LMSInitialize("");
    this.status = this.api.LMSGetValue("cmi.core.lesson_status");
    if (!DONE.includes(this.status)) this.set("cmi.core.lesson_status", (this.status = "incomplete"));
    this.interactions = Number(this.api.LMSGetValue("cmi.interactions._count")) || 0;
    window.addEventListener("pagehide", () => this.end());
    window.addEventListener("beforeunload", () => this.end());
    let kept: Kept | null = null;
    try {
      kept = JSON.parse(this.api.LMSGetValue("cmi.suspend_data") || "null") as Kept | null;
    } catch {
      // of another lesson, or cut: the visit begins anew
    }
    this.commit();
    return Promise.resolve(kept);
  }

  answered(answer: Answer): void {
    const at = `cmi.interactions.${this.interactions++}`;
    this.set(`${at}.id`, `chapter_${answer.chapter + 1}_question_${answer.question + 1}`);
    this.set(`${at}.type`, answer.byChoice ? "choice" : "performance");
    this.set(`${at}.time`, new Date().toTimeString().slice(0, 8));
    this.set(`${at}.student_response`, answer.response.slice(0, 255));
    this.set(`${at}.result`, answer.right ? "correct" : "wrong");
  }

  progress(standing: Standing): void {
    if (this.over) return;
    this.set("cmi.core.lesson_location", `${standing.chapter + 1}.${standing.step + 1}`);
    this.set("cmi.suspend_data", JSON.stringify(standing.kept()));
    if (standing.score !== null) {
      this.set("cmi.core.score.min", "0");
      this.set("cmi.core.score.max", "100");
      this.set("cmi.core.score.raw", String(standing.score));
    }
    if (standing.complete) {
      const { passed } = standing;
      this.set("cmi.core.lesson_status", (this.status = passed === null ? "completed" : passed ? "passed" : "failed"));
    }
    clearTimeout(this.soon);
    this.soon = window.setTimeout(() => this.commit(), SOON);
  }

  private end(): void {
    if (this.over) return;
    this.over = true;
    clearTimeout(this.soon);
    this.set("cmi.core.session_time", span(Date.now() - this.began));
    this.set("cmi.core.exit", DONE.includes(this.status) ? "" : "suspend");
    this.api.LMSCommit("");
    this.api.LMSFinish("");
  }

  private commit(): void {
    if (!this.over) this.api.LMSCommit("");
  }

  private set(key: string, value: string): void {
    this.api.LMSSetValue(key, value);
  }
}

/** Milliseconds as SCORM 1.2 writes a span of time: HHHH:MM:SS.SS. */
function span(milliseconds: number): string {
  const seconds = milliseconds / 1000;
  const two = (value: number): string => String(Math.floor(value)).padStart(2, "0");
  const hours = String(Math.floor(seconds / 3600)).padStart(4, "0");
  return `${hours}:${two((seconds / 60) % 60)}:${(seconds % 60).toFixed(2).padStart(5, "0").replace("60.00", "59.99")}`;
}
