import CopyPlugin from "copy-webpack-plugin";

export default {
  mode: "production",
  entry: "./main.js",
  output: { filename: "main.js", publicPath: "auto", clean: true },
  // The runtime has a megabyte; it is loaded beside the page, not before it.
  performance: { hints: false },
  plugins: [new CopyPlugin({ patterns: ["public"] })],
};
