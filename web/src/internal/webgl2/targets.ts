/** Multisampled colour and depth, and the way from there to the canvas, remade when the picture's size changes. */
export class Targets {
  readonly #width: number;
  readonly #height: number;
  readonly #samples: WebGLFramebuffer;
  readonly #resolved: WebGLFramebuffer;
  readonly #renderbuffers: WebGLRenderbuffer[] = [];

  constructor(gl: WebGL2RenderingContext, width: number, height: number, sampleCount: number) {
    this.#width = width;
    this.#height = height;
    this.#samples = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#samples);
    this.#attach(gl, gl.COLOR_ATTACHMENT0, gl.RGBA8, sampleCount);
    this.#attach(gl, gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24, sampleCount);
    this.#resolved = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#resolved);
    this.#attach(gl, gl.COLOR_ATTACHMENT0, gl.RGBA8, 0);
  }

  #attach(gl: WebGL2RenderingContext, attachment: GLenum, format: GLenum, sampleCount: number): void {
    const buffer = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, sampleCount, format, this.#width, this.#height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, buffer);
    this.#renderbuffers.push(buffer);
  }

  /** Begins a picture. */
  begin(gl: WebGL2RenderingContext): void {
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#samples);
    gl.viewport(0, 0, this.#width, this.#height);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  /** Averages the samples, and turns the picture over into the canvas: shaders draw with the first row on top. */
  present(gl: WebGL2RenderingContext): void {
    const width = this.#width;
    const height = this.#height;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.#samples);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, this.#resolved);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.#resolved);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, width, height, 0, height, width, 0, gl.COLOR_BUFFER_BIT, gl.NEAREST);
  }

  /** Gives the memory back. */
  free(gl: WebGL2RenderingContext): void {
    for (const buffer of this.#renderbuffers) gl.deleteRenderbuffer(buffer);
    gl.deleteFramebuffer(this.#samples);
    gl.deleteFramebuffer(this.#resolved);
  }
}
