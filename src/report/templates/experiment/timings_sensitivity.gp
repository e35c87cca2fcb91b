array titles[3] = ['drift, any start phase', 'start phase, at a drift of 5 ppm', 'load, any start phase']
array labels[3] = ['drift [ppm]', 'phase [us]', 'cost of its controllers, times']
@canvas 1200,320
set multiplot layout 1,3
do for [i = 1:3] {
  @panel
  set title titles[i]
  set xlabel labels[i]
  set ylabel 'unserved cycles [%]'
  if (i == 2) { set xrange [0:1000] }
  plot $single using (of(1, i - 1, "value")):"unserved [%]" @points lc rgb REFERENCE title i == 2 ? '' : 'single runs', \
    $data using (of(1, i - 1, "value")):"mean unserved [%]" @line lc rgb RS title 'RS'
}
