/** What the page has to show. A further avatar or motion is one more entry, and `cargo xtask pictures` makes its picture. */

/** @typedef {{ id: string, name: string, src: string, poster?: string, alt: string }} Avatar */
/** @typedef {{ id: string, name: string, src: string, fps: number, still: number }} Motion `still`: the moment of its picture, seconds */

/** @type {readonly Avatar[]} */
export const AVATARS = [
  {
    id: "shirt-dancer",
    name: "Long shirt",
    src: "web/assets/shirt-dancer.glb",
    poster: "demo/pictures/shirt-dancer.webp",
    alt: "A person in a long loose shirt and jeans",
  },
  {
    id: "tee-turner",
    name: "T-shirt",
    src: "web/assets/tee-turner.glb",
    poster: "demo/pictures/tee-turner.webp",
    alt: "A person in a T-shirt and loose trousers",
  },
];

/** @type {readonly Motion[]} */
export const MOTIONS = [
  { id: "dance_a", name: "Dance A", src: "web/assets/motions/dance_a.pkl", fps: 60, still: 1.2 },
  { id: "dance_b", name: "Dance B", src: "web/assets/motions/dance_b.pkl", fps: 60, still: 2.6 },
  { id: "spin", name: "Spin", src: "web/assets/motions/spin.pkl", fps: 60, still: 1.0 },
  { id: "spinkick", name: "Spin kick", src: "web/assets/motions/spinkick.pkl", fps: 60, still: 0.35 },
  { id: "cartwheel", name: "Cartwheel", src: "web/assets/motions/cartwheel.pkl", fps: 60, still: 1.4 },
];

/** The entry of that id, or one of the visitor's own where it is an address; the first one where there is nothing. */
export function find(list, wanted) {
  if (wanted === null || wanted === "") return list[0];
  const known = list.find(({ id }) => id === wanted);
  return known ?? { ...list[0], id: wanted, name: wanted.split("/").pop(), src: wanted };
}
