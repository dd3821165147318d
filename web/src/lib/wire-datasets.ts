// What the server says of datasets and of the list of them, as it comes from the wire.
import {
  DatasetNews as WireNews,
  OnDisk as WireOnDisk,
  type DatasetEntry as WireEntry,
  type DatasetInfo as WireDatasetInfo,
  type DatasetList as WireList,
} from '../gen/isostrata/v1/isostrata_pb';
import type { DatasetEntry, DatasetInfo, DatasetList } from './told';
import { names } from './protocol';
import { vecOf } from './wire-scene';

const news = names(WireNews, 'none');
const onDisk = names(WireOnDisk, 'as read');

export function datasetInfoOf({ points, cells, cellTypes, lower, upper, arrays, onDisk: files, ...rest }: WireDatasetInfo): DatasetInfo {
  return {
    ...rest,
    points: Number(points),
    cells: Number(cells),
    cellTypes: Object.entries(cellTypes).map(([type, count]) => [type, Number(count)]),
    bounds: lower && upper ? { lower: vecOf(lower), upper: vecOf(upper) } : null,
    arrays: arrays.map(({ nanCount, stepLower, stepUpper, cellLower, cellUpper, ...array }) => ({
      ...array,
      nanCount: Number(nanCount),
      cells: cellLower !== undefined && cellUpper !== undefined && cellLower <= cellUpper ? { lower: cellLower, upper: cellUpper } : null,
      steps: stepLower.map((least, step) => ({ lower: least, upper: stepUpper[step] ?? least })),
    })),
    onDisk: onDisk.name(files),
  };
}

export const entryOf = ({ bytes, changedUnixMs, noticedUnixMs, news: what, ...rest }: WireEntry): DatasetEntry => ({
  ...rest,
  bytes: Number(bytes),
  changedMs: changedUnixMs,
  noticedMs: noticedUnixMs,
  news: news.name(what),
});

export const listOf = ({ folders, datasets, passedOver, nowUnixMs, ...rest }: WireList): DatasetList => ({
  ...rest,
  folders: folders.map(({ changedUnixMs, ...folder }) => ({ ...folder, changedMs: changedUnixMs })),
  datasets: datasets.map(entryOf),
  passedOver: passedOver.map((group) => ({ ...group, files: Number(group.files) })),
  nowMs: nowUnixMs,
});
