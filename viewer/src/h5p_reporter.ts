// Reports to the H5P library around the page (shared/lappet/export/h5p_library/lesson.js), by messages between windows.
import type { Answer, Reporter } from "./reporter";
import type { Kept, Standing } from "./standing";

const PATIENCE = 2000; // milliseconds that the library may take to say what an earlier visit left

export class H5pReporter implements Reporter {
  begin(): Promise<Kept | null> {
    return new Promise((resolve) => {
      const hear = (event: MessageEvent): void => {
        if (event.source !== window.parent || event.data?.lappet !== "resume") return;
        window.removeEventListener("message", hear);
        resolve((event.data as { state: Kept | null }).state);
      };
      window.addEventListener("message", hear);
      window.setTimeout(() => resolve(null), PATIENCE);
      this.tell({ lappet: "begin" });
    });
  }

  answered(answer: Answer): void {
    this.tell({ lappet: "answered", ...answer });
  }

  progress(standing: Standing): void {
    this.tell({
      lappet: "progress",
      state: standing.kept(),
      right: standing.rightAnswers(),
      questions: standing.questions,
      answered: standing.results.flat().filter((each) => each !== "-").length,
      completed: standing.complete,
      passed: standing.passed,
    });
  }

  private tell(message: object): void {
    window.parent.postMessage(message, "*");
  }
}
