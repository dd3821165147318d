// Places to look from that a person keeps, for each dataset; the browser has them until they are deleted.
import { rescaled } from './camera';
import type { Box, Camera, Vec3 } from './model';

export interface KeptView {
  name: string;
  camera: Camera;
  axisScale: Vec3; // with which it was kept
}

export const mostKept = 50;
export const longestName = 40;

const isVec = (of: unknown): of is Vec3 => Array.isArray(of) && of.length === 3 && of.every(Number.isFinite);
const isView = (of: unknown): of is KeptView => {
  const { name, camera, axisScale } = (of ?? {}) as KeptView;
  return typeof name === 'string' && isVec(axisScale) && !!camera && isVec(camera.eye) && isVec(camera.at) && isVec(camera.up) && Number.isFinite(camera.fovDeg);
};

/** Storage can be forbidden or full; then a view is kept as long as the page shows them. */
export class KeptViews {
  readonly #key: string;

  /** path: of the page, since several servers can share one origin below a proxy. */
  constructor(
    private readonly store: () => Pick<Storage, 'getItem' | 'setItem'>,
    path: string,
    dataset: string,
  ) {
    this.#key = `isostrata.${path}.views.${dataset}`;
  }

  /** What was stored is not trusted. */
  get list(): KeptView[] {
    try {
      const stored: unknown = JSON.parse(this.store().getItem(this.#key) ?? '[]');
      return Array.isArray(stored) ? stored.filter(isView).slice(0, mostKept) : [];
    } catch {
      return [];
    }
  }
  /** The list with it. A view of the same name gives its place to the new one; without a name it is the next of "View 1", "View 2" and so on. */
  keep(name: string, camera: Camera, axisScale: Vec3 = [1, 1, 1]): KeptView[] {
    const before = this.list;
    let number = before.length + 1;
    while (before.some((view) => view.name === `View ${number}`)) number++;
    const view = { name: name.trim().slice(0, longestName) || `View ${number}`, camera, axisScale };
    const same = before.findIndex((of) => of.name === view.name);
    return this.#write(same < 0 ? [...before, view] : before.map((of, i) => (i === same ? view : of)));
  }
  /** The list without it. */
  remove(name: string): KeptView[] {
    return this.#write(this.list.filter((view) => view.name !== name));
  }

  #write(views: KeptView[]): KeptView[] {
    try {
      this.store().setItem(this.#key, JSON.stringify(views));
    } catch {
      // See above.
    }
    return views;
  }
}

/** The camera as the axes are drawn now. bounds: the file's. */
export const cameraOf = ({ camera, axisScale }: KeptView, bounds: Box, now: Vec3 = [1, 1, 1]): Camera => rescaled(camera, axisScale, now, bounds);
