# names: a quantity and its unit for each panel
count = |names| / 2
rows = (count + 1) / 2
@canvas 900,rows*220
set multiplot layout rows,2
do for [i = 1:count] {
  @panel
  set title names[2*i - 1]
  set xlabel names[2*i]
  set ylabel 'runs'
  set yrange [0:*]
  set boxwidth
  plot $data using (of("panel", i, "centre")):"runs":"width" @bars fc rgb LF notitle
}
