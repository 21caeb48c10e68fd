import type { Studio } from "./answers.js";
import { StageError } from "./errors.js";
import type { Request } from "./protocol.js";
import { webm } from "./webm.js";

/** Codecs that WebM holds, the best first: what WebCodecs and what Matroska call them. */
const CODECS = [
  ["vp09.00.40.08", "V_VP9"],
  ["vp8", "V_VP8"],
] as const;

/** Frames that may wait for the encoder. */
const MOST_WAITING = 4;
/** Bits a pixel that keep folds sharp. */
const BITS_PER_PIXEL = 0.16;
const KEY_FRAME_SECONDS = 2;

/** A film of the motion from where it stands: every frame at its exact moment, however long it takes to draw. */
export async function record(studio: Studio, request: Request & { kind: "record" }): Promise<Blob> {
  const { viewer } = studio;
  const before = { seconds: viewer.currentTime, playing: viewer.playing, wish: studio.wish() };
  try {
    return await film(studio, request);
  } finally {
    // Who has pressed a button meanwhile means what comes afterwards.
    const wish = studio.wish();
    viewer.seek(before.seconds);
    if (wish.order === before.wish.order ? before.playing : wish.playing) viewer.play();
    studio.draw(null);
  }
}

async function film(studio: Studio, request: Request & { kind: "record" }): Promise<Blob> {
  if (typeof VideoEncoder !== "function") {
    throw new StageError("unsupported", "record: expected a browser with WebCodecs, found none");
  }
  const { viewer, canvas } = studio;
  const { framesPerSecond } = request;
  const start = viewer.currentTime;
  const { duration } = viewer;
  const count = Math.max(Math.round(request.seconds * framesPerSecond), 1);
  const microseconds = 1e6 / framesPerSecond;
  const keyInterval = Math.max(Math.round(KEY_FRAME_SECONDS * framesPerSecond), 1);

  const chunks: { readonly key: boolean; readonly milliseconds: number; readonly bytes: Uint8Array }[] = [];
  let failed: unknown = null;
  const encoder = new VideoEncoder({
    output: (chunk) => {
      const bytes = new Uint8Array(chunk.byteLength);
      chunk.copyTo(bytes);
      chunks.push({ key: chunk.type === "key", milliseconds: Math.round(chunk.timestamp / 1000), bytes });
    },
    error: (error) => {
      failed = error;
    },
  });
  const check = (): void => {
    if (failed) throw new StageError("unsupported", `record: expected a film, found ${String(failed)}`);
  };

  let codec = "";
  let size = { width: 0, height: 0 };
  let now = performance.now();
  try {
    for (let index = 0; index < count; index += 1) {
      const seconds = start + index / framesPerSecond;
      viewer.showExactly(viewer.looping && duration > 0 ? seconds % duration : seconds);
      // Time stands but for the camera, which goes on by one frame.
      now += 1000 / framesPerSecond;
      const frame = studio.withSize(request.size, () => {
        studio.draw(now);
        return new VideoFrame(canvas, {
          timestamp: Math.round(index * microseconds),
          duration: Math.round(microseconds),
        });
      });
      if (index === 0) {
        // Encoders of most kinds want even sides.
        size = { width: frame.codedWidth & ~1, height: frame.codedHeight & ~1 };
        const bitrate = request.bitsPerSecond ?? BITS_PER_PIXEL * size.width * size.height * framesPerSecond;
        codec = await configure(encoder, { ...size, bitrate, framerate: framesPerSecond });
      }
      const { width, height } = size;
      const even = new VideoFrame(frame, { visibleRect: { x: 0, y: 0, width, height } });
      frame.close();
      encoder.encode(even, { keyFrame: index % keyInterval === 0 });
      even.close();
      while (encoder.encodeQueueSize > MOST_WAITING && !failed) await pause();
      check();
    }
    await encoder.flush();
    check();
  } finally {
    if (encoder.state !== "closed") encoder.close();
  }
  return new Blob(webm({ codec, ...size, seconds: count / framesPerSecond, chunks }), { type: "video/webm" });
}

/** Sets `encoder` up with the best codec that it has; returns Matroska's name of it. */
async function configure(encoder: VideoEncoder, picture: Omit<VideoEncoderConfig, "codec">): Promise<string> {
  for (const [codec, name] of CODECS) {
    const config = { ...picture, codec };
    const { supported } = await VideoEncoder.isConfigSupported(config);
    if (!supported) continue;
    encoder.configure(config);
    return name;
  }
  throw new StageError(
    "unsupported",
    `record: expected an encoder of VP9 or VP8 for ${picture.width} × ${picture.height} pixels, found none`,
  );
}

function pause(): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, 4));
}
