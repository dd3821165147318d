// Dark, light, or as the system has it.

export type Theme = 'system' | 'dark' | 'light';
const key = 'isostrata.theme';

export class ThemeChoice {
  current = $state<Theme>('system');

  constructor() {
    try {
      const stored = localStorage.getItem(key);
      if (stored === 'dark' || stored === 'light') this.current = stored;
    } catch {
      // Storage can be forbidden; the choice then lives as long as the page.
    }
    this.#apply();
  }

  next(): void {
    this.current = this.current === 'system' ? 'dark' : this.current === 'dark' ? 'light' : 'system';
    try {
      localStorage.setItem(key, this.current);
    } catch {
      // See above.
    }
    this.#apply();
  }

  #apply(): void {
    document.documentElement.dataset.theme = this.current;
  }
}
