import type { CreaseAvatarElement } from "crease-avatar";
import type { DetailedHTMLProps, HTMLAttributes } from "react";

/** React hands a prop to the property of that name where the element has one, and to the attribute otherwise. */
type Props = DetailedHTMLProps<HTMLAttributes<CreaseAvatarElement>, CreaseAvatarElement> & {
  src?: string;
  motion?: string;
  fps?: number;
  detail?: number;
  autoplay?: boolean;
  loop?: boolean;
  alt?: string;
  "camera-controls"?: boolean;
};

declare module "react" {
  namespace JSX {
    interface IntrinsicElements {
      "crease-avatar": Props;
    }
  }
}
