import type { PictureLayout, Viewer } from "../../../pkg/crease.js";
import type { MemoryView } from "./memory.js";
import { TEXTURE_UNITS } from "./program.js";

/** Texels in a row of the texture of vertices. */
const ROW = 1024;

/** Indices of one level. */
interface Indices {
  readonly buffer: WebGLBuffer;
  readonly count: number;
}

/** The figure: static drawn topology, and this frame's vertices in a texture, for WebGL2 has no storage buffers. */
export class Figure {
  readonly #vertexArray: WebGLVertexArrayObject;
  /** Indices of each level, level 0 first. */
  readonly #levels: Indices[] = [];
  /** Edges of each level; none until they are wanted. */
  readonly #lines: Indices[] = [];
  readonly #vertices: WebGLTexture;
  #revision = 0;

  constructor(gl: WebGL2RenderingContext, viewer: Viewer, layout: PictureLayout, memory: MemoryView) {
    this.#vertices = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + TEXTURE_UNITS.figure_vertices);
    gl.bindTexture(gl.TEXTURE_2D, this.#vertices);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32UI, ROW, Math.ceil(viewer.vertices / ROW));
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);

    const mesh = viewer.drawnMesh();
    this.#vertexArray = gl.createVertexArray();
    gl.bindVertexArray(this.#vertexArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, memory.words, gl.STATIC_DRAW, mesh.verticesAddress / 4, mesh.verticesBytes / 4);
    const stride = layout.drawnVertexBytes;
    for (const location of [0, 1, 2]) gl.enableVertexAttribArray(location);
    gl.vertexAttribIPointer(0, 1, gl.UNSIGNED_INT, stride, 0);
    gl.vertexAttribPointer(1, 2, gl.FLOAT, false, stride, layout.textureCoordinatesOffset);
    gl.vertexAttribPointer(2, 4, gl.UNSIGNED_BYTE, true, stride, layout.colourOffset);
    for (let level = 0; level < mesh.levelCount; level += 1) {
      this.#levels.push(this.#indexBuffer(gl, memory, mesh.indicesAddress(level), mesh.indexCount(level)));
    }
    mesh.free();
  }

  /** Uploads the viewer's vertices unless they are there already. */
  update(gl: WebGL2RenderingContext, viewer: Viewer, memory: MemoryView): void {
    if (this.#revision === viewer.revision) return;
    this.#revision = viewer.revision;
    gl.activeTexture(gl.TEXTURE0 + TEXTURE_UNITS.figure_vertices);
    const first = viewer.verticesAddress / 4;
    const rows = Math.floor(viewer.vertexCount / ROW);
    const rest = viewer.vertexCount % ROW;
    const { words } = memory;
    const format = gl.RGBA_INTEGER;
    const type = gl.UNSIGNED_INT;
    if (rows > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ROW, rows, format, type, words, first);
    if (rest > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, rows, rest, 1, format, type, words, first + 4 * ROW * rows);
  }

  /** Draws the level `coarser` levels below the finest (level 0 where there are fewer) with the program in use. */
  draw(gl: WebGL2RenderingContext, coarser: number): void {
    this.#drawLevel(gl, gl.TRIANGLES, this.#levels, coarser);
  }

  /** The same for the edges, which are made when they are wanted first. */
  drawLines(gl: WebGL2RenderingContext, viewer: Viewer, memory: MemoryView, coarser: number): void {
    if (this.#lines.length === 0) {
      const mesh = viewer.drawnMesh();
      for (let level = 0; level < mesh.levelCount; level += 1) {
        const address = mesh.edgesAddress(level);
        this.#lines.push(this.#indexBuffer(gl, memory, address, mesh.edgeIndexCount));
      }
      mesh.free();
    }
    this.#drawLevel(gl, gl.LINES, this.#lines, coarser);
  }

  #indexBuffer(gl: WebGL2RenderingContext, memory: MemoryView, address: number, count: number): Indices {
    const buffer = gl.createBuffer();
    gl.bindVertexArray(this.#vertexArray);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, memory.words, gl.STATIC_DRAW, address / 4, count);
    return { buffer, count };
  }

  #drawLevel(gl: WebGL2RenderingContext, mode: GLenum, levels: readonly Indices[], coarser: number): void {
    const level = levels[Math.max(levels.length - 1 - coarser, 0)];
    if (!level) return;
    gl.bindVertexArray(this.#vertexArray);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, level.buffer);
    gl.drawElements(mode, level.count, gl.UNSIGNED_INT, 0);
  }
}
