// What nobody sees at first, as one file beside the page's first one.
export { default as CurveDock } from './CurveDock.svelte';
export { default as CutList } from './CutList.svelte';
export { default as FileBrowser } from './FileBrowser.svelte';
export { default as FilmForm } from './FilmForm.svelte';
export { default as FilmProgress } from './FilmProgress.svelte';
export { default as Help } from './Help.svelte';
export { default as KeptViews } from './KeptViews.svelte';
export { default as LayerNumbers } from './LayerNumbers.svelte';
export { default as ModeControls } from './ModeControls.svelte';
export { default as ProbeCard } from './ProbeCard.svelte';
export { default as Sharing } from './Sharing.svelte';
export { default as SurfaceLook } from './SurfaceLook.svelte';
export { default as TransferCurve } from './TransferCurve.svelte';
export { viewOf, viewText } from '../lib/view-file';
