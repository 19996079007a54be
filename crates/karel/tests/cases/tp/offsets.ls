/PROG  OFFSETS
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  PR[1]=LPOS ;
   2:  PR[1,1]=10 ;
   3:  PR[1,2]=0 ;
   4:  PR[1,3]=0 ;
   5:  PR[1,4]=0 ;
   6:  PR[1,5]=0 ;
   7:  PR[1,6]=0 ;
   8:  PR[2]=PR[1]+PR[1] ;
   9:  OFFSET CONDITION PR[1] ;
  10:  TOOL_OFFSET CONDITION PR[2] ;
  11:J P[1] 50% FINE Offset ;
  12:L P[1] 50mm/sec FINE Offset,PR[2] ;
  13:L P[1] 50mm/sec FINE Tool_Offset ;
  14:L P[1] 50mm/sec FINE Tool_Offset,PR[1] ;
  15:J P[3] 50% FINE Offset,PR[1] ;
/POS
P[1:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 900.000 mm,	Y = 0.000 mm,	Z = 700.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[2:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F U T, 0, 0, -1',
	X = 800.000 mm,	Y = 100.000 mm,	Z = 600.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[3]{
   GP1:
	UF : F, UT : F,
	J1 = 10.000 deg,	J2 = 20.000 deg,	J3 = -30.000 deg,	J4 = 0.000 deg,	J5 = -60.000 deg,	J6 = 5.000 deg
};
/END
