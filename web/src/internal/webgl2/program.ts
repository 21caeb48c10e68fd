import type { ProgramSource } from "../../../pkg/webgl2_shaders.js";
import { StageError } from "../errors.js";

/** Where uniform blocks are bound; blocks by their variable in WGSL. */
export const BLOCK_BINDINGS = { globals: 0, clip_from_world: 1 } as const;

/** Units that textures are bound to, by their variable in WGSL. */
export const TEXTURE_UNITS = {
  figure_vertices: 0,
  albedo: 1,
  key_map: 2,
  key_depths: 3,
  below_depths: 4,
} as const;

/** Compiles and links `source`, its blocks and textures bound to the places above. */
export function compileProgram(gl: WebGL2RenderingContext, source: ProgramSource): WebGLProgram {
  const program = gl.createProgram();
  const shaders = [
    compileShader(gl, gl.VERTEX_SHADER, source.vertex),
    compileShader(gl, gl.FRAGMENT_SHADER, source.fragment),
  ];
  for (const shader of shaders) gl.attachShader(program, shader);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    const logs = [gl.getProgramInfoLog(program), ...shaders.map((shader) => gl.getShaderInfoLog(shader))];
    throw new StageError("device", `WebGL2 refused a program: ${logs.filter(Boolean).join("; ")}`);
  }
  for (const shader of shaders) gl.deleteShader(shader);
  for (const [name, variable] of Object.entries(source.blocks)) {
    gl.uniformBlockBinding(
      program,
      gl.getUniformBlockIndex(program, name),
      BLOCK_BINDINGS[variable as keyof typeof BLOCK_BINDINGS],
    );
  }
  gl.useProgram(program);
  for (const [name, variable] of Object.entries(source.textures)) {
    gl.uniform1i(gl.getUniformLocation(program, name), TEXTURE_UNITS[variable as keyof typeof TEXTURE_UNITS]);
  }
  return program;
}

function compileShader(gl: WebGL2RenderingContext, kind: GLenum, text: string): WebGLShader {
  const shader = gl.createShader(kind);
  // Only a lost context makes none; whoever draws asks for that.
  if (!shader) throw new StageError("device-lost", "WebGL2 lost its context while it compiled a shader");
  gl.shaderSource(shader, text);
  gl.compileShader(shader);
  return shader;
}
