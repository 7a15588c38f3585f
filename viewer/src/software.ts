// Whether no graphics processor draws, but the processor in its place: then fewer pixels and shadows are drawn.
let known: boolean | undefined;

export function drawsInSoftware(): boolean {
  return (known ??= asked());
}

function asked(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}
