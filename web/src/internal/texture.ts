import type { Viewer, EncodedImage as WasmImage } from "../../pkg/crease.js";
import { StageError } from "./errors.js";
import { type FetchOptions, fetchBytes, fileName } from "./fetch.js";
import type { Painter } from "./painter.js";

/** A picture file's bytes and their media type. */
export interface EncodedImage {
  readonly mime: string;
  readonly bytes: Uint8Array;
}

/** A picture out of the wasm module, copied out of its memory. */
function copied(image: WasmImage): EncodedImage {
  const { mime, bytes } = image;
  image.free();
  return { mime, bytes };
}

/** The texture of the viewer's own avatar. */
export function ownTexture(viewer: Viewer): EncodedImage | null {
  const image = viewer.textureImage;
  return image ? copied(image) : null;
}

/** The picture at `url`, or the texture of the avatar there; that one must be laid out as the viewer's. */
export async function loadTexture(viewer: Viewer, url: string, options: FetchOptions): Promise<EncodedImage> {
  const bytes = await fetchBytes(url, options);
  const isGlb = new TextDecoder("latin1").decode(bytes.subarray(0, 4)) === "glTF";
  const image = isGlb ? copied(viewer.textureOf(bytes, fileName(url))) : { mime: "", bytes };
  // A file that is no picture is told of here, before anything has changed.
  (await decode(image, url)).close();
  return image;
}

/** Gives `painter` the texture, decoded; without one the figure has the colours of its vertices. */
export async function setTexture(painter: Painter, image: EncodedImage | null): Promise<void> {
  if (!image) return;
  const bitmap = await decode(image, null);
  painter.setTexture(bitmap);
  bitmap.close();
}

/** The picture, decoded as it is stored. */
export async function decode({ mime, bytes }: EncodedImage, url: string | null): Promise<ImageBitmap> {
  const blob = new Blob([bytes as Uint8Array<ArrayBuffer>], { type: mime });
  try {
    return await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  } catch (thrown) {
    const name = url === null ? "texture" : fileName(url);
    throw new StageError("texture", `${name}: expected a picture, found ${String(thrown)}`, url);
  }
}
