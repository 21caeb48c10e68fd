/** How the custom-elements manifest is made from the sources: `npm run manifest`. */

/** Sources are not in the package: modules go by the name that importers use. */
function shippedPaths() {
  const shipped = (path) => (path === "src/public/crease-avatar.ts" ? "lib/crease-avatar.js" : path);
  const rename = (node) => {
    if (Array.isArray(node)) {
      for (const item of node) rename(item);
    } else if (node !== null && typeof node === "object") {
      for (const key of ["path", "module"]) {
        if (typeof node[key] === "string") node[key] = shipped(node[key]);
      }
      for (const value of Object.values(node)) rename(value);
    }
  };
  return { name: "shipped-paths", packageLinkPhase: ({ customElementsManifest }) => rename(customElementsManifest) };
}

/** Private members, the browser's callbacks and events without a word of documentation are nobody's interface. */
function publicMembers() {
  const isPublic = ({ name, privacy }) => !name.startsWith("#") && privacy !== "private" && !/Callback$/u.test(name);
  return {
    name: "public-members",
    packageLinkPhase({ customElementsManifest }) {
      for (const module of customElementsManifest.modules) {
        for (const declaration of module.declarations) {
          if (declaration.members) declaration.members = declaration.members.filter(isPublic);
          if (declaration.events) declaration.events = declaration.events.filter(({ description }) => description);
        }
      }
    },
  };
}

export default {
  globs: ["src/public/crease-avatar.ts", "src/internal/element/*.ts"],
  outdir: ".",
  packagejson: false,
  plugins: [publicMembers(), shippedPaths()],
};
