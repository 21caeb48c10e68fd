export default {
  base: "./",
  // The development server's pre-bundling would tear the worker from its script.
  optimizeDeps: { exclude: ["crease-avatar"] },
  worker: { format: "es" },
};
