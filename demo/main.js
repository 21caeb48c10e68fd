/** The demo: the element, and around it what a visitor plays with. Each part is a module of its own. */

import { AVATARS, find, MOTIONS } from "./catalogue.js";
import { setUpClothes } from "./clothes.js";
import { setUpComparison } from "./comparison.js";
import { setUpDetail } from "./detail.js";
import { setUpDrop } from "./drop.js";
import { setUpEmbed } from "./embed.js";
import { setUpFigures } from "./figures.js";
import { setUpLight } from "./light.js";
import { setUpPersons } from "./persons.js";
import { setUpSaves } from "./saves.js";
import { applyLink, setUpShare } from "./share.js";
import { setUpShelf } from "./shelf.js";
import { Show } from "./show.js";
import { setUpTheme } from "./theme.js";
import { setUpTransport } from "./transport.js";
import { setUpViews } from "./views.js";

const avatar = document.querySelector("#avatar");
const link = new URLSearchParams(location.search);
const show = new Show(avatar);

setUpTheme(avatar);
setUpShelf(show);
setUpPersons(show);
setUpClothes(show);
setUpDetail(avatar);
setUpComparison(show);
setUpViews(avatar);
setUpLight(avatar);
setUpSaves(show);
setUpTransport(avatar);
setUpFigures(show);
setUpDrop(show);
setUpShare(show);
setUpEmbed(show);

show.wear(find(AVATARS, link.get("avatar")));
show.dance(find(MOTIONS, link.get("motion")));
applyLink(avatar, link);
