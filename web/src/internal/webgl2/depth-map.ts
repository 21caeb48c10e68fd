import { depthMap } from "../../../pkg/webgl2_shaders.js";
import type { Figure } from "./figure.js";
import type { MemoryView } from "./memory.js";
import { BLOCK_BINDINGS, compileProgram } from "./program.js";

const MATRIX_BYTES = 64;

/** The figure's depth as a light sees it. */
export class DepthMap {
  readonly texture: WebGLTexture;
  readonly #texels: number;
  readonly #coarser: number;
  readonly #framebuffer: WebGLFramebuffer;
  readonly #matrix: WebGLBuffer;
  readonly #program: WebGLProgram;

  constructor(gl: WebGL2RenderingContext, texels: number, coarser: number) {
    this.#texels = texels;
    this.#coarser = coarser;
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT16, texels, texels);
    this.#framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.texture, 0);
    this.#matrix = gl.createBuffer();
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.#matrix);
    gl.bufferData(gl.UNIFORM_BUFFER, MATRIX_BYTES, gl.DYNAMIC_DRAW);
    this.#program = compileProgram(gl, depthMap);
  }

  /** Fills the map with `figure`, `coarser` levels coarser at least, seen through the matrix at `address`. */
  draw(gl: WebGL2RenderingContext, figure: Figure, coarser: number, memory: MemoryView, address: number): void {
    gl.bindBufferBase(gl.UNIFORM_BUFFER, BLOCK_BINDINGS.clip_from_world, this.#matrix);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, memory.words, address / 4, MATRIX_BYTES / 4);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framebuffer);
    gl.viewport(0, 0, this.#texels, this.#texels);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.depthFunc(gl.LESS);
    gl.disable(gl.BLEND);
    gl.disable(gl.CULL_FACE);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.#program);
    figure.draw(gl, Math.max(this.#coarser, coarser));
  }
}
