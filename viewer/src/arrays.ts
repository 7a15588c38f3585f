// The arrays of a lesson, as `shared/lappet/export/lesson_arrays.py` writes them.

export interface ArrayEntry {
  at: number;
  count: number;
  width: 1 | 2 | 4;
  back: number;
}

export interface PositionsEntry {
  low: [number, number, number];
  step: number;
  states: number;
  places: number;
  array: ArrayEntry;
}

export class BrokenLesson extends Error {
  constructor(
    readonly key: string,
    readonly values: Record<string, number> = {},
  ) {
    super(key);
  }
}

/** Inflates the block; throws BrokenLesson where it is cut or damaged. */
export async function inflate(base64: string, bytes: number, size: number): Promise<Uint8Array> {
  if (typeof DecompressionStream === "undefined") throw new BrokenLesson("broken.browser");
  const text = base64.replace(/\s+/g, "");
  const whole = text.slice(0, text.length - (text.length % 4));
  let deflated: Uint8Array<ArrayBuffer>;
  try {
    const raw = atob(whole);
    deflated = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) deflated[i] = raw.charCodeAt(i);
  } catch {
    throw new BrokenLesson("broken.data");
  }
  if (deflated.length !== bytes) throw new BrokenLesson("broken.cut", { found: deflated.length, expected: bytes });
  try {
    const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
    const block = new Uint8Array(await new Response(stream).arrayBuffer());
    if (block.length === size) return block;
  } catch {
    // told below
  }
  throw new BrokenLesson("broken.data");
}

export class Arrays {
  constructor(private readonly block: Uint8Array) {}

  /** The numbers of an entry: planes of bytes, unfolded, summed up modulo their width. */
  numbers(entry: ArrayEntry): Uint8Array | Uint16Array | Uint32Array {
    const { at, count, width } = entry;
    if (at + count * width > this.block.length) throw new BrokenLesson("broken.data");
    const back = Math.max(1, entry.back);
    const out = width === 1 ? new Uint8Array(count) : width === 2 ? new Uint16Array(count) : new Uint32Array(count);
    const b = this.block;
    for (let i = 0; i < count; i++) {
      let folded = b[at + i];
      if (width > 1) folded |= b[at + count + i] << 8;
      if (width > 2) folded |= (b[at + 2 * count + i] << 16) | (b[at + 3 * count + i] << 24);
      const difference = (folded >>> 1) ^ -(folded & 1);
      const before = i >= back ? out[i - back] : i > 0 ? out[i - 1] : 0;
      out[i] = before + difference;
    }
    return out;
  }

  positions(entry: PositionsEntry): Positions {
    return new Positions(entry, this.numbers(entry.array) as Uint16Array);
  }
}

/** Places that move, state by state. */
export class Positions {
  readonly places: number;
  readonly states: number;

  constructor(
    private readonly entry: PositionsEntry,
    private readonly whole: Uint16Array,
  ) {
    this.places = entry.places;
    this.states = entry.states;
  }

  /** Writes the places between two states: x, y, z of each. */
  write(into: Float32Array, state: number, next = state, share = 0): void {
    const { places: n, step, low } = this.entry;
    for (let axis = 0; axis < 3; axis++) {
      const a = (3 * state + axis) * n;
      const b = (3 * next + axis) * n;
      for (let i = 0, at = axis; i < n; i++, at += 3) {
        const here = this.whole[a + i];
        into[at] = low[axis] + step * (here + share * (this.whole[b + i] - here));
      }
    }
  }
}
