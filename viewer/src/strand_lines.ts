// The lines of each frame, as `lesson_strands.py` writes them.
import type { Arrays } from "./arrays";
import type { Strands } from "./lesson";
import type { Line } from "./tubes";

export function strandLines(strands: Strands, arrays: Arrays): Line[][] {
  const counts = arrays.numbers(strands.counts);
  const radii = arrays.numbers(strands.radii);
  const positions = arrays.positions(strands.points);
  const place = new Float32Array(3);
  const frames: Line[][] = [];
  let line = 0;
  let point = 0;
  for (const many of strands.lines) {
    const lines: Line[] = [];
    for (let k = 0; k < many; k++, line++) {
      const made: Line = { points: new Float32Array(3 * counts[line]), radii: new Float32Array(counts[line]) };
      for (let i = 0; i < counts[line]; i++, point++) {
        positions.write(place, point);
        made.points.set(place, 3 * i);
        (made.radii as Float32Array)[i] = radii[point] * strands.radiusStep;
      }
      lines.push(made);
    }
    frames.push(lines);
  }
  return frames;
}
