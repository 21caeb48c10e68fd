/** A film in a WebM file (Matroska's elements, RFC 8794 and RFC 9559): one video track, every frame at its time. */

/** What a file is made of. */
export interface Film {
  /** Matroska's name of the codec. */
  readonly codec: string;
  /** Pixels. */
  readonly width: number;
  readonly height: number;
  readonly seconds: number;
  /** Encoded frames, in their order. */
  readonly chunks: readonly { readonly key: boolean; readonly milliseconds: number; readonly bytes: Uint8Array }[];
}

type Bytes = Uint8Array<ArrayBuffer>;

/** A block's time counts from its cluster's start in 16 signed bits. */
const LONGEST_CLUSTER_MILLISECONDS = 30_000;
const VIDEO_TRACK = 1;

/** The parts of the file, in order. */
export function webm(film: Film): Bytes[] {
  const header = element(0x1a45dfa3, [
    unsigned(0x4286, 1), // EBMLVersion
    unsigned(0x42f7, 1), // EBMLReadVersion
    unsigned(0x42f2, 4), // EBMLMaxIDLength
    unsigned(0x42f3, 8), // EBMLMaxSizeLength
    text(0x4282, "webm"), // DocType
    unsigned(0x4287, 4), // DocTypeVersion
    unsigned(0x4285, 2), // DocTypeReadVersion
  ]);
  const information = element(0x1549a966, [
    unsigned(0x2ad7b1, 1_000_000), // TimestampScale: nanoseconds in a millisecond
    float(0x4489, 1000 * film.seconds), // Duration
    text(0x4d80, "crease"), // MuxingApp
    text(0x5741, "crease"), // WritingApp
  ]);
  const tracks = element(0x1654ae6b, [
    element(0xae, [
      unsigned(0xd7, VIDEO_TRACK), // TrackNumber
      unsigned(0x73c5, VIDEO_TRACK), // TrackUID
      unsigned(0x83, 1), // TrackType: video
      unsigned(0x9c, 0), // FlagLacing
      text(0x86, film.codec), // CodecID
      element(0xe0, [unsigned(0xb0, film.width), unsigned(0xba, film.height)]), // Video: PixelWidth, PixelHeight
    ]),
  ]);
  const segment = element(0x18538067, [information, tracks, ...clusters(film.chunks)]);
  return [header, segment];
}

/** A cluster begins with a key frame. */
function clusters(chunks: Film["chunks"]): Bytes[] {
  const found: { start: number; blocks: Bytes[] }[] = [];
  for (const chunk of chunks) {
    let cluster = found.at(-1);
    if (!cluster || chunk.key || chunk.milliseconds - cluster.start > LONGEST_CLUSTER_MILLISECONDS) {
      cluster = { start: chunk.milliseconds, blocks: [] };
      found.push(cluster);
    }
    cluster.blocks.push(block(chunk, cluster.start));
  }
  return found.map(({ start, blocks }) => element(0x1f43b675, [unsigned(0xe7, start), ...blocks]));
}

/** SimpleBlock: track, time within the cluster, flags, frame. */
function block({ key, milliseconds, bytes }: Film["chunks"][number], start: number): Bytes {
  const body = new Uint8Array(4 + bytes.length);
  body[0] = 0x80 | VIDEO_TRACK;
  new DataView(body.buffer).setInt16(1, milliseconds - start);
  body[3] = key ? 0x80 : 0;
  body.set(bytes, 4);
  return element(0xa3, [body]);
}

/** Identifier, length in eight bytes, content. */
function element(identifier: number, parts: readonly Bytes[]): Bytes {
  const id = bigEndian(identifier);
  const length = parts.reduce((sum, part) => sum + part.length, 0);
  const all = new Uint8Array(id.length + 8 + length);
  all.set(id);
  const view = new DataView(all.buffer);
  view.setBigUint64(id.length, (1n << 56n) | BigInt(length));
  let at = id.length + 8;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

function unsigned(identifier: number, value: number): Bytes {
  return element(identifier, [bigEndian(value)]);
}

function float(identifier: number, value: number): Bytes {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value);
  return element(identifier, [bytes]);
}

function text(identifier: number, value: string): Bytes {
  return element(identifier, [new TextEncoder().encode(value)]);
}

/** The fewest bytes that hold `value`, at least one. */
function bigEndian(value: number): Bytes {
  const bytes: number[] = [];
  let rest = value;
  do {
    bytes.unshift(rest % 256);
    rest = Math.floor(rest / 256);
  } while (rest > 0);
  return new Uint8Array(bytes);
}
