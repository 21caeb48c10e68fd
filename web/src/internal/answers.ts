import type { Viewer } from "../../pkg/crease.js";
import { StageError } from "./errors.js";
import type { Canvas, ClockWish, MeshFormat, PictureWish, Request } from "./protocol.js";
import { decode, type EncodedImage } from "./texture.js";

/** What answers are made with: the avatar at work. */
export interface Studio {
  readonly viewer: Viewer;
  readonly canvas: Canvas;
  readonly texture: EncodedImage | null;
  /** Time stands now, by the wish of this order. */
  obey(order: number): void;
  /** What time shall do. */
  wish(): ClockWish;
  /** Keeps the screen's own rhythm away until the answer is given; the page is told of no picture. */
  hold(): void;
  /** Draws now; `now`, in milliseconds, lets time pass, and null does not. */
  draw(now: number | null): void;
  /** Lets `draw` draw with another size of the picture; null is the element's. */
  withSize<T>(size: PictureWish["size"], draw: () => T): T;
}

const MEDIA_TYPES: Readonly<Record<MeshFormat, string>> = {
  glb: "model/gltf-binary",
  obj: "model/obj",
  ply: "model/ply",
};

/** Does what was asked for; `studio` throws where there is nothing to do it with. */
export async function answer(request: Request, studio: () => Studio): Promise<Blob | undefined> {
  const at = studio();
  switch (request.kind) {
    case "picture":
      return await picture(at, request.wish);
    case "mesh":
      return await mesh(at, request.format);
    case "render-frame":
      at.obey(request.order);
      at.viewer.showExactly(request.seconds);
      // The camera has arrived before the picture is drawn.
      at.viewer.settleCamera();
      at.draw(null);
      return undefined;
    case "record":
      at.hold();
      return await (await import("./record.js")).record(at, request);
  }
}

async function picture({ canvas, draw, withSize }: Studio, { type, quality, size }: PictureWish): Promise<Blob> {
  const encode = withSize(size, () => {
    draw(null);
    // Read in the same task as it is drawn: afterwards the picture belongs to the screen.
    return encoded(canvas, type, quality);
  });
  // The element's own size again, before anybody sees the other.
  if (size) draw(null);
  return await encode;
}

function encoded(canvas: Canvas, type: string, quality: number | null): Promise<Blob> {
  const options = quality === null ? { type } : { type, quality };
  if ("convertToBlob" in canvas) return canvas.convertToBlob(options);
  return new Promise((resolve, reject) => {
    const done = (blob: Blob | null): void => {
      if (blob) resolve(blob);
      else reject(new StageError("canvas", `toBlob: expected a picture of type ${type}, found none`));
    };
    canvas.toBlob(done, type, quality ?? undefined);
  });
}

async function mesh({ viewer, texture }: Studio, format: MeshFormat): Promise<Blob> {
  const bytes = viewer.exportMesh(format, texture?.mime, texture?.bytes, await texels(texture, format));
  return new Blob([bytes as Uint8Array<ArrayBuffer>], { type: MEDIA_TYPES[format] });
}

/** The texture's texels, for formats that hold colours but no picture: width, height, then RGBA. */
async function texels(texture: EncodedImage | null, format: MeshFormat): Promise<Uint8Array | undefined> {
  if (!texture || format === "glb") return undefined;
  const bitmap = await decode(texture, null);
  const { width, height } = bitmap;
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  if (!context) throw new StageError("unsupported", "exportMesh: expected a 2D canvas, found none");
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  const { data } = context.getImageData(0, 0, width, height);
  const all = new Uint8Array(8 + data.length);
  new DataView(all.buffer).setUint32(0, width, true);
  new DataView(all.buffer).setUint32(4, height, true);
  all.set(data, 8);
  return all;
}
