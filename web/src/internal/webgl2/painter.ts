import type { PictureLayout, Viewer } from "../../../pkg/crease.js";
import * as programs from "../../../pkg/webgl2_shaders.js";
import { StageError } from "../errors.js";
import type { Runtime } from "../module.js";
import type { Canvas } from "../protocol.js";
import { DepthMap } from "./depth-map.js";
import { Figure } from "./figure.js";
import { MemoryView } from "./memory.js";
import { BLOCK_BINDINGS, compileProgram, TEXTURE_UNITS } from "./program.js";
import { Targets } from "./targets.js";

/** Draws one viewer's scene on one canvas through WebGL2: the passes of the wasm module's renderer, in their order. */
export class WebGl2Painter {
  readonly #canvas: Canvas;
  readonly #gl: WebGL2RenderingContext;
  readonly #memory: MemoryView;
  readonly #layout: PictureLayout;
  readonly #sky: WebGLProgram;
  readonly #floor: WebGLProgram;
  readonly #lit: WebGLProgram;
  readonly #lines: WebGLProgram;
  readonly #keyMap: DepthMap;
  readonly #belowMap: DepthMap;
  readonly #globals: WebGLBuffer;
  readonly #empty: WebGLVertexArrayObject;
  #figure: Figure | null = null;
  #targets: Targets | null = null;
  #size = { width: 0, height: 0 };
  #lost = false;

  constructor(canvas: Canvas, { PictureLayout, memory }: Runtime) {
    const options = { antialias: false, depth: false, powerPreference: "high-performance" } as const;
    const gl = canvas.getContext("webgl2", options) as WebGL2RenderingContext | null;
    if (!gl) throw new StageError("unsupported", "WebGL2 is not available");
    canvas.addEventListener("webglcontextlost", () => {
      this.#lost = true;
    });
    this.#canvas = canvas;
    this.#gl = gl;
    this.#memory = new MemoryView(memory);
    const layout = new PictureLayout();
    this.#layout = layout;
    this.#keyMap = new DepthMap(gl, layout.keyMapTexels, layout.keyMapCoarser);
    this.#belowMap = new DepthMap(gl, layout.belowMapTexels, layout.belowMapCoarser);
    this.#sky = compileProgram(gl, programs.sky);
    this.#floor = compileProgram(gl, programs.floor);
    this.#lit = compileProgram(gl, programs.figure);
    this.#lines = compileProgram(gl, programs.lines);
    this.#empty = gl.createVertexArray();
    this.#globals = gl.createBuffer();
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.#globals);
    gl.bufferData(gl.UNIFORM_BUFFER, layout.globalsBytes, gl.DYNAMIC_DRAW);
    this.#bindMaps();
    this.#setAlbedo((target) => {
      gl.texStorage2D(target, 1, gl.SRGB8_ALPHA8, 1, 1);
      gl.texSubImage2D(target, 0, 0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4).fill(255));
    });
    // The projection of the shaders turns the picture over, and with it the sense of triangles.
    gl.frontFace(gl.CW);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** The key map is read twice: compared and filtered, and texel by texel. */
  #bindMaps(): void {
    const gl = this.#gl;
    const bind = (variable: keyof typeof TEXTURE_UNITS, map: DepthMap, compare: boolean): void => {
      const unit = TEXTURE_UNITS[variable];
      const sampler = gl.createSampler();
      const filter = compare ? gl.LINEAR : gl.NEAREST;
      gl.samplerParameteri(sampler, gl.TEXTURE_MIN_FILTER, filter);
      gl.samplerParameteri(sampler, gl.TEXTURE_MAG_FILTER, filter);
      gl.samplerParameteri(sampler, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
      gl.samplerParameteri(sampler, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
      gl.samplerParameteri(sampler, gl.TEXTURE_COMPARE_MODE, compare ? gl.COMPARE_REF_TO_TEXTURE : gl.NONE);
      gl.samplerParameteri(sampler, gl.TEXTURE_COMPARE_FUNC, gl.LEQUAL);
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, map.texture);
      gl.bindSampler(unit, sampler);
    };
    bind("key_map", this.#keyMap, true);
    bind("key_depths", this.#keyMap, false);
    bind("below_depths", this.#belowMap, false);
  }

  #setAlbedo(fill: (target: GLenum) => void): void {
    const gl = this.#gl;
    gl.activeTexture(gl.TEXTURE0 + TEXTURE_UNITS.albedo);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    fill(gl.TEXTURE_2D);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
  }

  /**
   * Lets the albedo be seen at a slant. A figure without a texture has none of it: its coordinates are all the same, and across no distance at
   * all Mesa's filter in software answers with NaN.
   */
  #filterAlbedoAtASlant(): void {
    const gl = this.#gl;
    const anisotropic = gl.getExtension("EXT_texture_filter_anisotropic");
    if (!anisotropic) return;
    const most = gl.getParameter(anisotropic.MAX_TEXTURE_MAX_ANISOTROPY_EXT) as number;
    const wanted = Math.min(this.#layout.anisotropy, most);
    gl.texParameterf(gl.TEXTURE_2D, anisotropic.TEXTURE_MAX_ANISOTROPY_EXT, wanted);
  }

  /** Takes what never changes about the viewer's figure, its detail included. */
  prepare(viewer: Viewer): void {
    this.#figure = new Figure(this.#gl, viewer, this.#layout, this.#memory);
  }

  /** All of the detail comes from the viewer. */
  prepareDetail(): void {}

  /** Takes the decoded texture of the figure. */
  setTexture(bitmap: ImageBitmap): void {
    const gl = this.#gl;
    const levels = 1 + Math.floor(Math.log2(Math.max(bitmap.width, bitmap.height)));
    this.#setAlbedo((target) => {
      gl.texStorage2D(target, levels, gl.SRGB8_ALPHA8, bitmap.width, bitmap.height);
      gl.texSubImage2D(target, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    });
    this.#filterAlbedoAtASlant();
  }

  /** Size of the picture in pixels of the device. */
  resize(width: number, height: number): void {
    const gl = this.#gl;
    const limit = gl.getParameter(gl.MAX_RENDERBUFFER_SIZE) as number;
    this.#size = { width: Math.min(width, limit), height: Math.min(height, limit) };
    this.#targets?.free(gl);
    this.#targets = null;
  }

  /** Targets of the picture's size. A canvas that takes another size is empty until it is drawn on: both in one go. */
  #sizedTargets(): Targets | null {
    const { width, height } = this.#size;
    if (!this.#targets && width > 0 && height > 0) {
      this.#canvas.width = width;
      this.#canvas.height = height;
      this.#targets = new Targets(this.#gl, width, height, this.#layout.sampleCount);
    }
    return this.#targets;
  }

  /** Posing is left to the wasm module. */
  poses(): boolean {
    return false;
  }

  /** The browser holds animation frames back by itself where WebGL does not keep up. */
  keepsUp(): boolean {
    return true;
  }

  /** Draws the viewer's scene. Returns whether there was something to draw on. */
  draw(viewer: Viewer): boolean {
    const gl = this.#gl;
    const figure = this.#figure;
    const targets = this.#sizedTargets();
    const memory = this.#memory;
    if (!figure || !targets) return false;
    figure.update(gl, viewer, memory);
    const layout = this.#layout;
    const globals = viewer.globalsAddress(this.#size.width / this.#size.height);
    gl.bindBufferBase(gl.UNIFORM_BUFFER, BLOCK_BINDINGS.globals, this.#globals);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, memory.words, globals / 4, layout.globalsBytes / 4);
    this.#keyMap.draw(gl, figure, viewer.coarser, memory, globals + layout.keyMatrixOffset);
    this.#belowMap.draw(gl, figure, viewer.coarser, memory, globals + layout.belowMatrixOffset);

    targets.begin(gl);
    gl.depthFunc(gl.LEQUAL);
    gl.depthMask(false);
    gl.bindVertexArray(this.#empty);
    gl.useProgram(this.#sky);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.BLEND);
    gl.useProgram(this.#floor);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.enable(gl.CULL_FACE);
    gl.useProgram(this.#lit);
    figure.draw(gl, viewer.coarser);
    const { coarserLines } = viewer;
    if (coarserLines !== undefined) {
      gl.useProgram(this.#lines);
      figure.drawLines(gl, viewer, memory, coarserLines);
    }
    targets.present(gl);
    return true;
  }

  /** Throws if the context was lost. */
  check(): void {
    if (this.#lost || this.#gl.isContextLost()) throw new StageError("device-lost", "the graphics context was lost");
  }

  /** Loses the context as a driver's restart does, for tests. */
  lose(): void {
    this.#gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  /** Gives the context back: browsers allow a page only a few. */
  free(): void {
    this.#layout.free();
    this.lose();
  }
}
