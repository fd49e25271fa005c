// Workers as modules, since planish's load more of them; the newer target is for the await at main.ts's top.
export default {
  base: './',
  build: { target: 'es2022', assetsInlineLimit: 0 },
  worker: { format: 'es' },
  optimizeDeps: { exclude: ['planish'] },
};
